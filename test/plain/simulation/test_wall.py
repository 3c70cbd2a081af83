"""The simulated wall: its file, its rendering compared with the truth, and the robot's motion."""
import cv2
import numpy as np
import pytest
from aruco_ar import Detector, InputError, find_area
from aruco_ar.simulation.render import WallRenderer, project, project_rows
from aruco_ar.simulation.robot import Camera, Path, Pose, drive, hand_held, load_path, wall_to_camera
from aruco_ar.walls.wall import load_wall

LENS = Camera(distortion=[-0.25, 0.08, 0.001, -0.001, 0.0])


@pytest.mark.parametrize('camera', [Camera(), LENS], ids=['pinhole', 'lens'])
@pytest.mark.parametrize('pose', [Pose(-2.2, 0, 0), Pose(-1.9, 0.6, -0.3), Pose(-3.0, -1.0, 0.35)])
def test_tags_are_where_the_truth_says(wall, camera, pose):
    view = wall_to_camera(pose)
    tags = Detector().detect(WallRenderer(wall, camera).render(*view))
    assert sorted(tag.id for tag in tags) == [1, 2, 3, 4]
    truth = {tag.id: project(tag.corners, *view, camera)[0] for tag in wall.tags}
    errors = np.concatenate([tag.corners - truth[tag.id] for tag in tags])
    assert np.abs(errors).max() < 1.5
    assert np.abs(errors.mean(axis=0)).max() < 0.15  # the tags are not all shifted


def test_rim_pixels_are_blended_in_proportion(wall):
    """A tag's black border is seen straight on; the sum of its gray gives its extent."""
    camera, view = Camera(), wall_to_camera(Pose(-2.013, 0.2, 0))
    frame = WallRenderer(wall, camera).render(*view)
    tag = wall.tags[0]
    pixels, _ = project(tag.corners, *view, camera)
    row = int(pixels[:, 1].mean() - (pixels[3, 1] - pixels[0, 1]) * 0.44)  # in the black border
    left, right = int(pixels[0, 0]) - 4, int(pixels[1, 0]) + 6
    line = frame[row, left:right].mean(axis=1)
    white, black = line[:2].mean(), line[len(line) // 2]
    dark = np.sum((white - line[:len(line) // 2]) / (white - black))
    assert left + len(line) // 2 - 0.5 - dark == pytest.approx(pixels[0, 0], abs=0.08)


def test_noise_blur_and_light_are_rendered(wall):
    view = wall_to_camera(Pose(-2.2, 0, 0))
    plain = WallRenderer(wall, Camera()).render(*view).astype(int)
    noisy = WallRenderer(wall, Camera(), noise=5)
    one, other = noisy.render(*view).astype(int), noisy.render(*view).astype(int)
    assert np.std(one - plain) == pytest.approx(5, rel=0.1)
    assert np.std(one - other) == pytest.approx(5 * 2**0.5, rel=0.1)  # the noise is different in each frame
    blurred = WallRenderer(wall, Camera(), blur=3).render(*view)
    assert cv2.Laplacian(blurred, cv2.CV_64F).std() < cv2.Laplacian(np.uint8(plain), cv2.CV_64F).std() / 3
    lit = WallRenderer(wall, Camera(), light=0.8).render(*view).astype(int)
    darker = lit[60:80] / plain[60:80]
    assert darker[:, :40].mean() > darker[:, -40:].mean() + 0.1


@pytest.mark.parametrize('pose', [Pose(-2, 0, np.pi), Pose(-0.1, 0, 0), Pose(0.5, 0, 0), Pose(-0.3, 4.0, -1.5),
                                  Pose(-2, 0, np.pi / 2), Pose(-50, 0, 0)])
def test_any_view_can_be_rendered(wall, pose):
    frame = WallRenderer(wall, LENS).render(*wall_to_camera(pose))
    assert frame.shape == (480, 640, 3)
    assert Detector().detect(frame) == []


def test_the_turn_of_a_tag_is_clockwise(tmp_path, wall):
    text = ('wall: {width: 4, height: 2, color: [200, 200, 200]}\ndictionary: DICT_4X4_50\ntags:\n'
            + ''.join('- {id: %d, x: %g, y: %g, side: 0.3, turn: 90}\n' % (i, x, y)
                      for i, (x, y) in enumerate([(-.5, 1), (.5, 1), (.5, .3), (-.5, .3)])))
    (tmp_path / 'wall.yaml').write_text(text)
    turned = load_wall(str(tmp_path / 'wall.yaml'))
    frame = WallRenderer(turned, Camera()).render(*wall_to_camera(Pose(-2.2, 0, 0)))
    tags = Detector('DICT_4X4_50').detect(frame)
    assert sorted(tag.id for tag in tags) == [0, 1, 2, 3]
    for tag in tags:  # its own top left is at the top right now
        assert np.argmin(tag.corners @ [-1, 1]) == 0


def test_posters_are_where_the_file_says(tmp_path):
    for name, color in ('wall', (0, 0, 250)), ('poster', (250, 0, 0)):
        cv2.imwrite(str(tmp_path / (name + '.png')), np.full((60, 90, 3), color, np.uint8))
    (tmp_path / 'wall.yaml').write_text(
        'wall: {image: wall.png}\nposters: [{image: poster.png, x: 0.2, y: 0.5, width: 0.8, height: 0.4}]\n'
        'tags: [{id: 1, x: -0.8, y: 0.5, side: 0.2}]')
    found, view = load_wall(str(tmp_path / 'wall.yaml')), wall_to_camera(Pose(-2.2, 0.1, 0.05))
    frame = WallRenderer(found, Camera()).render(*view)
    corners = project(found.posters[1].corners, *view, Camera())[0]
    for part, is_blue in (0.95, True), (1.05, False):  # of the way from the middle to a corner
        for x, y in np.round(corners.mean(axis=0) + part * (corners - corners.mean(axis=0))).astype(int):
            assert (frame[y, x, 0] > 200) == is_blue and (frame[y, x, 2] > 200) != is_blue
    (tmp_path / 'poster.png').unlink()
    with pytest.raises(InputError, match=r'poster\.png'):
        WallRenderer(found, Camera())


@pytest.mark.parametrize('camera', [Camera(), LENS], ids=['pinhole', 'lens'])
def test_the_truth_includes_a_rolling_shutter_and_a_shaking_hand(wall, camera):
    first = wall_to_camera(Pose(-2.2, 0, 0))
    last = hand_held(wall_to_camera(Pose(-2.2, 0.02, 0.03)), 0.3, 2.0)
    truth, in_front = project_rows(wall.area_corners, first, last, camera)
    found = find_area(Detector().detect(WallRenderer(wall, camera).render(*first, last=last)))
    assert in_front and np.abs(truth - project(wall.area_corners, *first, camera)[0]).max() > 3
    np.testing.assert_allclose(found.corners, truth, atol=0.3)


def test_a_hand_shakes_all_the_time_but_only_a_little():
    still = wall_to_camera(Pose(-2.2, 0, 0))
    views = [hand_held(still, seconds / 30, 1.0) for seconds in range(300)]
    turns = [np.linalg.norm(cv2.Rodrigues(rotation @ still[0].T)[0]) for rotation, _ in views]
    assert 0.01 < max(turns) < 0.03 and np.ptp([translation for _, translation in views], axis=0).max() < 0.1
    np.testing.assert_array_equal(hand_held(still, 5.0, 0.0)[0], still[0])


def test_exposure_and_compression_are_rendered(wall):
    view = wall_to_camera(Pose(-2.2, 0, 0))
    usual, light, dark = (WallRenderer(wall, Camera()).render(*view, exposure=times) for times in (1, 2, 0.5))
    assert np.median(light) == 255 and abs(np.median(dark) - np.median(usual) / 2) < 2
    packed = WallRenderer(wall, Camera(), quality=20).render(*view)
    assert 0.5 < np.abs(packed.astype(int) - usual).mean() < 5


@pytest.mark.parametrize('text, words', [
    ('', 'wrong form'), ('tags: [', 'not YAML'), ('tags: []', 'at least one'),
    ('wall: {width: 5}', "lacks the entry 'tags'"),
    ('posters: [{x: 0, y: 0, width: 1, height: 1}]\ntags: []', "'image'"),
    ('wall: {plaster: 11}\ntags: []', '11 is not'),
    ('tags:\n- {id: 1, x: 0, y: 0, side: 1}\n- {id: 1, x: 0, y: 0, side: 1}', 'each id only once'),
    ('wall: {width: 1, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\ntags:\n- {id: 1, x: 0}', "'y'"),
    ('wall: {width: .nan, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\ntags: []', 'nan is not'),
    ('wall: {width: 1, height: 1, color: [1, 1, 999]}\ndictionary: DICT_4X4_50\ntags: []', '999 is not'),
    ('wall: {width: 1, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\nquiet: -1\ntags: []',
     '-1 is not'),
    (('wall: {width: 1, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\n'
      'tags:\n- {id: 4.7, x: 0, y: 0, side: 1}'), '4.7 is not an id'),
    (('wall: {width: 1, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\n'
      'tags:\n- {id: true, x: 0, y: 0, side: 1}'), 'True is not an id'),
    ('wall: {width: 1, height: 1, color: [1, 1]}\ndictionary: DICT_4X4_50\ntags: []', 'wrong form'),
    (('wall: {width: 1, height: 1, color: [1, 1, 1]}\ndictionary: DICT_4X4_50\n'
      'tags:\n- {id: 1, x: 0, y: 0, side: 1}\narea: [1]'), 'four different'),
])
def test_a_wrong_wall_file_is_explained(assert_refused, text, words):
    assert_refused(load_wall, text, words)


@pytest.mark.long
@pytest.mark.parametrize('distortion', [[np.nan, 0, 0, 0, 0], [-5, 1, 0, 0, 0], [0, 0, 0.5, 0.5, 0]])
def test_an_impossible_distortion_is_refused(wall, distortion):
    with pytest.raises(InputError, match='smaller coefficients'):
        WallRenderer(wall, Camera(width=160, height=120, distortion=distortion))


def test_a_missing_file_is_named():
    with pytest.raises(InputError, match='"/nowhere/path.yaml" cannot be read'):
        load_path('/nowhere/path.yaml')


def test_the_robot_drives_along_an_arc():
    straight = drive(Pose(0, 0, np.pi / 2), 0.5, 0, 2)
    np.testing.assert_allclose(straight, (0, 1, np.pi / 2), atol=1e-12)
    quarter = drive(Pose(0, 0, 0), np.pi / 2, np.pi / 2, 1)  # radius 1, to the left
    np.testing.assert_allclose(quarter, (1, 1, np.pi / 2), atol=1e-12)
    steps = Pose(-2, 0, 0.3)
    for _ in range(100):
        steps = drive(steps, 0.4, -0.2, 0.01)
    np.testing.assert_allclose(steps, drive(Pose(-2, 0, 0.3), 0.4, -0.2, 1), atol=1e-9)


def test_a_path_repeats(package):
    path = load_path(package + '/config/drive.yaml')
    np.testing.assert_allclose(path.at(path.seconds - 1e-9)[0], path.start, atol=1e-6)
    np.testing.assert_allclose(path.at(3 * path.seconds + 1.5)[0], path.at(1.5)[0], atol=1e-9)
    assert Path(Pose(0, 0, 0), ((1.0, 1.0, 0.0), (1.0, 0.0, 1.0))).at(1.5) == (Pose(1, 0, 0.5), 0.0, 1.0)
