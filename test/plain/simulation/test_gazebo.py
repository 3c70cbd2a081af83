"""The wall for Gazebo: its files as libsdformat and a camera see them, and the command that makes them."""
import os
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from aruco_ar import Detector
from aruco_ar.simulation.gazebo import wall_files
from aruco_ar.simulation.render import project
from aruco_ar.simulation.robot import Camera, Pose, wall_to_camera
from aruco_ar.tags.tag import tag_cells
from aruco_ar.walls.wall import load_wall

MODEL = 'models/unit5_wall/'
WORLD = 'worlds/wall.world'
FINE = 8  # samples per pixel, in each direction
TURNED = ('wall: {width: 4, height: 2, color: [200, 190, 180]}\ndictionary: DICT_4X4_50\nquiet: %g\ntags:\n'
          + ''.join('- {id: %d, x: %g, y: %g, side: 0.24, turn: %g}\n' % (i, x, y, turn) for i, (x, y, turn) in
                    enumerate([(-.5, .9, 90), (.5, .9, 90), (.5, .35, 90), (-.5, .35, 30)])))


@pytest.fixture(params=['config', 'turned', 'no quiet zone', 'narrow quiet zone', 'wide quiet zone'])
def any_wall(request, wall, tmp_path):
    if request.param == 'config':
        return wall
    quiet = {'turned': 1, 'no quiet zone': 0, 'narrow quiet zone': 0.25, 'wide quiet zone': 2}[request.param]
    (tmp_path / 'wall.yaml').write_text(TURNED % quiet)
    return load_wall(str(tmp_path / 'wall.yaml'))


def decode(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE)


def sdf(files, path):
    return ElementTree.fromstring(files[path])


def read_mesh(files):
    """The faces of the mesh in world coordinates: [(texture, (4, 3) points, (4, 2) texture places, normal)]."""
    model, world = sdf(files, MODEL + 'model.sdf'), sdf(files, WORLD)
    visual, = [visual for visual in model.iter('visual') if visual.find('geometry/mesh') is not None]
    assert visual.find('geometry/mesh/uri').text == 'model://unit5_wall/meshes/tags.obj'
    for parent in (visual, model.find('model'), model.find('model/link'), world.find('world/include')):
        assert parent.find('pose') is None  # so the mesh's coordinates are those of the world
    textures = {}
    for line in files[MODEL + 'meshes/tags.mtl'].decode().splitlines():
        key, _, value = line.partition(' ')
        if key == 'newmtl':
            material = value
        elif key == 'map_Kd':
            textures[material] = decode(files[MODEL + 'meshes/' + value])
    table, faces = {'v': [], 'vt': [], 'vn': []}, []
    for line in files[MODEL + 'meshes/tags.obj'].decode().splitlines():
        key, *values = line.split()
        if key in table:
            table[key].append([float(value) for value in values])
        elif key == 'usemtl':
            material = values[0]
        elif key == 'f':
            corners = np.array([value.split('/') for value in values], int) - 1
            points, places, normals = (np.array(table[kind])[corners[:, column]]
                                       for column, kind in enumerate(('v', 'vt', 'vn')))
            assert np.ptp(normals, axis=0).max() == 0
            faces.append((textures[material], points, places, normals[0]))
    return faces


def read_fronts(files):
    """[(texture, (3, 3))]: the front faces, each with the matrix from its texture to the world.

    The matrix applies to (x, y, 1); x and y are pixels of the texture from its top left edge.
    """
    fronts = []
    for texture, points, places, normal in read_mesh(files):
        if normal[0] < -0.99:
            pixels = np.column_stack([places[:, 0] * texture.shape[1], (1 - places[:, 1]) * texture.shape[0],
                                      np.ones(len(places))])
            fronts.append((texture, np.linalg.lstsq(pixels, points, rcond=None)[0].T))
    return fronts


def on_wall(points):
    """Wall coordinates (right, up, out) of world points, (n, 3). The robot's x is into the wall."""
    return np.stack([-points[:, 1], points[:, 2], -points[:, 0]], axis=1)


def face_of_wall(files, kind):
    """The x of the wall's face toward the robot, and the face's size."""
    box = sdf(files, MODEL + 'model.sdf').find('.//%s[@name][pose]' % kind)
    x, y, z, *turn = map(float, box.find('pose').text.split())
    assert turn == [0, 0, 0]
    depth, width, height = map(float, box.find('geometry/box/size').text.split())
    assert (y, z) == (0, height / 2)
    return x - depth / 2, (width, height)


def photograph(files, pose):
    """(480, 640) uint8: the front faces as a robot's camera sees them, on a gray background."""
    camera = Camera(640 * FINE, 480 * FINE)
    rotation, translation = wall_to_camera(pose)
    frame = np.full((480 * FINE, 640 * FINE), 180, np.uint8)
    for texture, to_world in read_fronts(files):
        middles = np.array([[1, 0, .5], [0, 1, .5], [0, 0, 1]])  # the middle of pixel (0, 0) is at (0.5, 0.5)
        to_wall = np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]]) @ to_world @ middles
        to_frame = camera.matrix @ (rotation @ to_wall + np.outer(translation, [0, 0, 1]))
        cv2.warpPerspective(texture, to_frame, frame.shape[::-1], frame, cv2.INTER_LINEAR,
                            cv2.BORDER_TRANSPARENT)
    return cv2.resize(frame, (640, 480), interpolation=cv2.INTER_AREA)


@pytest.mark.parametrize('path', [MODEL + 'model.sdf', WORLD])
def test_libsdformat_accepts_the_files(package, path):
    tool = shutil.which('gz') or shutil.which('ign')
    if not tool:
        pytest.skip('neither gz (Gazebo) nor ign (ignition-tools, libsdformat-dev) is installed')
    models = package + '/gazebo/models'
    done = subprocess.run([tool, 'sdf', '-k', '%s/gazebo/%s' % (package, path)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True,
                          env=dict(os.environ, SDF_PATH=models, GAZEBO_MODEL_PATH=models))
    assert done.returncode == 0 and 'Warning' not in done.stdout, done.stdout


def test_the_tags_are_where_the_wall_file_says(any_wall):
    fronts = read_fronts(wall_files(any_wall))
    assert len(fronts) == len(any_wall.tags)
    for tag, (texture, to_world) in zip(any_wall.tags, fronts):
        rows, columns = np.nonzero(texture < 128)
        left, right, top, foot = columns.min(), columns.max() + 1, rows.min(), rows.max() + 1
        corners = to_world @ [[left, right, right, left], [top, top, foot, foot], [1] * 4]
        np.testing.assert_allclose(on_wall(corners.T), tag.corners, atol=1e-4)


@pytest.mark.parametrize('any_wall', ['config', 'turned', 'wide quiet zone'], indirect=True)
@pytest.mark.parametrize('pose', [Pose(-2.2, 0, 0), Pose(-1.9, 0.6, -0.3), Pose(-3.0, -1.0, 0.35)])
def test_a_camera_detects_the_tags(any_wall, pose):
    tags = Detector(any_wall.dictionary).detect(photograph(wall_files(any_wall), pose))
    assert sorted(tag.id for tag in tags) == sorted(tag.id for tag in any_wall.tags)
    truth = {tag.id: project(tag.corners, *wall_to_camera(pose), Camera())[0] for tag in any_wall.tags}
    for tag in tags:
        assert np.linalg.norm(tag.corners - truth[tag.id], axis=1).max() < 1


def test_textures_are_tags_on_white_paper(any_wall):
    for tag, (texture, _) in zip(any_wall.tags, read_fronts(wall_files(any_wall))):
        cells = tag_cells(any_wall.dictionary, tag.id)
        scale = round(len(texture) / (len(cells) + 2 * any_wall.quiet))
        margin, side = round(any_wall.quiet * scale), len(cells) * scale
        assert texture.shape == (side + 2 * margin, side + 2 * margin) and scale >= 32
        expected = np.full(texture.shape, 255, np.uint8)
        expected[margin:margin + side, margin:margin + side] = cells.repeat(scale, 0).repeat(scale, 1)
        np.testing.assert_array_equal(texture, expected)


def test_the_paper_is_in_front_of_the_wall(any_wall):
    files = wall_files(any_wall)
    bumper, size = face_of_wall(files, 'collision')
    plaster, same_size = face_of_wall(files, 'visual')
    assert bumper == 0 and 0.003 <= plaster <= 0.02
    assert size == same_size == (any_wall.width, any_wall.height)
    faces = read_mesh(files)
    assert len(faces) == 5 * len(any_wall.tags)
    middles = np.repeat([np.mean(faces[i][1], axis=0) for i in range(0, len(faces), 5)], 5, axis=0)
    for (texture, points, places, normal), middle in zip(faces, middles):
        assert set(np.round(points[:, 0], 6)) <= {0.0, round(plaster, 6)}
        # Gazebo only draws faces whose corners are counterclockwise as seen from outside.
        around = np.cross(points[1] - points[0], points[2] - points[1])
        np.testing.assert_allclose(around / np.linalg.norm(around), normal, atol=1e-4)
        assert normal[0] < -0.99 or normal @ (points.mean(axis=0) - middle) > 0
        if normal[0] > -0.99:  # a side has the color of the paper's rim
            rim = (np.array([[0, 1], [1, 0]]) @ places.T * (len(texture) - 1)).astype(int)
            assert np.all(texture[rim[0], rim[1]] == (255 if any_wall.quiet else 0))


def test_nothing_shines_and_the_light_is_even(wall):
    files = wall_files(wall)
    model, world = sdf(files, MODEL + 'model.sdf'), sdf(files, WORLD)
    shines = [element.text for root in (model, world) for element in root.iter('specular')]
    assert len(shines) == 3 and set(shines) == {'0 0 0 1'}
    materials = files[MODEL + 'meshes/tags.mtl'].decode()
    assert materials.count('newmtl') == materials.count('Ks 0 0 0') == materials.count('map_Kd') == 4
    light, = world.iter('light')
    assert light.get('type') == 'directional' and light.find('cast_shadows').text == 'false'
    direction = np.array(light.find('direction').text.split(), float)
    assert direction[0] > 0 > direction[2]  # from in front of the wall, and from above
    sun, ambient = (float(world.find(path).text.split()[0])
                    for path in ('world/light/diffuse', 'world/scene/ambient'))
    assert 0.8 < ambient + sun * direction[0] / np.linalg.norm(direction) < 1  # bright, but not overexposed
    assert [uri.text for uri in world.iter('uri')] == ['model://unit5_wall']  # the world needs no other model


def test_the_files_in_the_package_are_up_to_date(package, wall):
    folder, made = package + '/gazebo', wall_files(wall)
    shipped = {os.path.relpath(os.path.join(root, name), folder)
               for root, _, names in os.walk(folder) for name in names}
    assert shipped == set(made)
    for path, data in made.items():
        with open(os.path.join(folder, path), 'rb') as file:
            stored = file.read()
        if path.endswith('.png'):  # compared as pictures, since versions of libpng compress differently
            np.testing.assert_array_equal(decode(stored), decode(data), path)
        else:
            assert stored == data, path


@pytest.fixture
def command(package, tmp_path):
    """A function that runs gazebo_wall.py in an empty folder, and returns (exit code, output)."""
    def run(*arguments):
        done = subprocess.run([sys.executable, package + '/nodes/gazebo_wall.py', *arguments],
                              cwd=str(tmp_path), env=dict(os.environ, PYTHONPATH=package + '/src'),
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout
    return run


def test_the_command_makes_the_files_of_any_wall(command, tmp_path):
    (tmp_path / 'mine.yaml').write_text(TURNED % 2)
    code, output = command('--wall', 'mine.yaml', '--output', 'made', '__name:=gazebo_wall')
    assert code == 0 and str(tmp_path / 'made' / WORLD) in output
    for path, data in wall_files(load_wall(str(tmp_path / 'mine.yaml'))).items():
        assert (tmp_path / 'made' / path).read_bytes() == data


@pytest.mark.parametrize('arguments, words', [
    (['wall:=mine.yaml'], 'unrecognized arguments: wall:=mine.yaml'),
    (['--wall', 'none.yaml', '--output', 'made'], 'The file "none.yaml" cannot be read'),
    (['--output', '/dev/null/made'], 'Cannot write "/dev/null/made'),
])
def test_errors_are_sentences_and_leave_nothing_behind(command, tmp_path, arguments, words):
    code, output = command(*arguments)
    assert code != 0 and words in output and 'Traceback' not in output
    assert os.listdir(str(tmp_path)) == []
