"""annotate_bags.py: its results, their independence of the number of workers, restarts, and bad input."""
import csv
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress

import av
import cv2
import numpy as np
import psutil
import pytest
import rosbag
import rospy
from aruco_ar import Tracker
from aruco_node.messages.images import compressed_from_frame, frame_from_compressed, image_from_frame
from aruco_node.parameters.parameters import ros_values
from aruco_node.parameters.settings import BagSettings
from benchmark.ros.bags import BEGIN_S, record
from rig.accuracy.areas import follow
from rig.accuracy.drives import FRAMES_PER_S, LIVELY, PAINTING, drive
from rig.processes.started import WAIT_S
from sensor_msgs.msg import CameraInfo, CompressedImage
from std_msgs.msg import Header

SECONDS, PIECE_S = 6, 2
SEAM = 2 * PIECE_S * FRAMES_PER_S  # the number of a frame that is the first of a piece
COVERED = range(SEAM - 20, SEAM + 20)
pytestmark = pytest.mark.xdist_group('bags')  # in one process, which makes a bag once
CAMERA, PAINTED = '/camera/rgb/image_raw', '/exercise5_6/image/camera/rgb/image_raw/compressed'


@pytest.fixture(scope='module')
def frames():
    """Frames of a lively drive; two of the four tags are covered before and after a seam."""
    return list(drive(LIVELY, SECONDS * FRAMES_PER_S, lambda number: [1, 3] * (number in COVERED), noise=2.0))


@pytest.fixture(scope='module')
def recorded(frames, tmp_path_factory):
    """The path of a bag of these frames."""
    path = str(tmp_path_factory.mktemp('bags') / 'drive.bag')
    record(path, [frame.image for frame in frames], SECONDS, 'compressed')
    return path


def command_for(package, *arguments):
    return [sys.executable, os.path.join(package, 'nodes', 'annotate_bags.py'), '--piece', str(PIECE_S),
            *map(str, arguments)]


def annotate(package, folder, *arguments, code=0):
    """Run annotate_bags, which must end with this exit code; returns what it prints."""
    path = os.pathsep.join([os.path.join(package, 'src'), os.environ['PYTHONPATH']])  # package may be a copy
    done = subprocess.run(command_for(package, '--out', folder, *arguments), stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=WAIT_S,
                          env=dict(os.environ, PYTHONPATH=path))
    assert done.returncode == code, done.stdout
    return done.stdout


@pytest.fixture(scope='module')
def done(package, recorded, tmp_path_factory):
    """The folder with the results of a single process."""
    folder = tmp_path_factory.mktemp('done')
    annotate(package, folder, recorded, '--workers', '1', '--video')
    return folder


def rows_of(folder):
    with open(str(folder / 'tags.csv'), newline='') as table:
        return list(csv.DictReader(table))


def numbers(row, names):
    return np.array([float(row[name]) for name in names])


def area_of(row):
    return numbers(row, ['area%d_%s' % (number, axis) for number in range(4) for axis in 'xy']).reshape(4, 2)


def assert_same(folder, other):
    for name in 'drive.bag', 'tags.csv':
        assert (folder / name).read_bytes() == (other / name).read_bytes(), name


def test_the_area_is_correct_at_the_seams_too(frames, recorded, done):
    rows, tracker = rows_of(done), Tracker()
    numbers_of = [round((float(row['stamp']) - BEGIN_S) * FRAMES_PER_S) for row in rows]
    areas = {number: area_of(row) for number, row in zip(numbers_of, rows) if row['area0_x']}
    assert len(areas) > 0.99 * len(frames)
    assert set(range(SEAM - 5, SEAM + 5)) <= set(areas)
    with rosbag.Bag(recorded) as bag:
        in_one = [tracker.update(frame_from_compressed(message), message.header.stamp.to_sec()).corners
                  for _, message, _ in bag.read_messages([CAMERA + '/compressed'])]
    for number, area in areas.items():
        # If one tag is left, as while two are covered and a third leaves the frame, much is predicted.
        assert np.abs(area - in_one[number]).max() < (2 if number in COVERED else 0.5), number
        # One tag alone does not determine the far side while the robot jerks.
        far = 1.0 if numbers_of.count(number) > 1 else 5.0
        assert np.abs(area - frames[number].corners).max() < far, number


def test_the_table_has_every_tag_in_every_frame(frames, done):
    rows = rows_of(done)
    assert {(row['bag'], row['topic']) for row in rows} == {('drive.bag', CAMERA + '/compressed')}
    first = [row for row in rows if row['stamp'] == rows[0]['stamp']]
    assert sorted(int(row['id']) for row in first) == [1, 2, 3, 4]
    assert all(float(row['confidence']) > 0.99 for row in first)
    for row in first:
        corners = numbers(row, ['corner%d_%s' % (number, axis) for number in range(4) for axis in 'xy'])
        center = numbers(row, ['center_x', 'center_y'])
        assert np.abs(frames[0].corners - center).max(axis=1).min() < 1
        assert np.abs(corners.reshape(4, 2) - center).max() < 60
        assert 1 < float(row['z']) < 4  # meters in front of the camera


def test_the_bag_has_the_painted_frames_with_their_stamps(frames, done):
    with rosbag.Bag(str(done / 'drive.bag')) as bag:
        painted = [message for _, message, _ in bag.read_messages([PAINTED])]
    assert [round((message.header.stamp.to_sec() - BEGIN_S) * FRAMES_PER_S) for message in painted] == \
        list(range(len(frames)))
    frame, image = frames[0].image, frame_from_compressed(painted[0])
    x, y = frames[0].corners.mean(axis=0).astype(int)
    off = np.abs(image.astype(int) - frame)
    assert off[y - 10:y + 10, x - 10:x + 10].mean() > 30 > 5 > off[:40].mean()


@pytest.mark.parametrize('arguments, code, words', [
    (['--help'], 0, 'usage:'),
    (['--video'], 1, 'annotate_bags: unit5 needs PyAV 12 or later, .* Or leave out --video')])
def test_only_videos_need_the_library_that_ros_has_no_package_for(package, tmp_path, arguments, code, words):
    start = 'import sys; sys.modules["av"] = None; import annotate_bags; annotate_bags.main(sys.argv[1:])'
    done = subprocess.run([sys.executable, '-c', start, 'some.bag', '--out', str(tmp_path), *arguments],
                          cwd=package + '/nodes', stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=WAIT_S)
    assert done.returncode == code and re.search(words, done.stdout), done.stdout
    assert 'Traceback' not in done.stdout


def test_the_video_has_all_frames(frames, done):
    video, count = cv2.VideoCapture(str(done / 'drive.mp4')), 0
    while video.grab():
        count += 1
    assert count == len(frames)
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(FRAMES_PER_S, rel=0.02)
    with av.open(str(done / 'drive.mp4')) as played:  # browsers play this, and begin before they have all of it
        codec = played.streams.video[0].codec_context
        assert (codec.name, codec.pix_fmt) == ('h264', 'yuv420p')
    data = (done / 'drive.mp4').read_bytes()
    assert data.index(b'moov') < data.index(b'mdat')


def test_the_result_does_not_depend_on_the_number_of_workers(package, recorded, done, tmp_path):
    annotate(package, tmp_path, recorded, '--workers', '3')
    assert_same(done, tmp_path)


def test_the_result_does_not_depend_on_how_the_bag_was_recorded(package, recorded, done, tmp_path):
    with rosbag.Bag(recorded) as bag:
        whole = [(topic, message, time) for topic, message, time in bag.read_messages(raw=True)]
    infos, images = ([each for each in whole if ('info' in each[0]) == is_info] for is_info in (True, False))
    half = len(images) // 2
    with rosbag.Bag(str(tmp_path / 'drive.bag'), 'w', compression='lz4', chunk_threshold=100000) as bag:
        bag.write('/unset_clock', Header(), rospy.Time.from_sec(BEGIN_S % PIECE_S))
        for topic, message, time in [infos[0], *images[half:], *images[half - 1::-1]]:
            bag.write(topic, message, time, raw=True)
    annotate(package, tmp_path / 'out', tmp_path / 'drive.bag')
    assert (tmp_path / 'out' / 'tags.csv').read_bytes() == (done / 'tags.csv').read_bytes()


def test_no_work_is_lost_if_a_worker_is_killed(package, recorded, done, tmp_path):
    with subprocess.Popen(command_for(package, '--out', tmp_path, '--workers', '2', recorded),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        wait_for_piece(tmp_path)
        workers = [child for child in psutil.Process(process.pid).children(recursive=True)
                   if 'spawn_main' in ' '.join(child.cmdline())]
        workers[-1].kill()
        assert process.wait(WAIT_S) == 0, process.stdout.read()
    assert_same(done, tmp_path)


def interrupted(package, recorded, folder):
    """Interrupt annotate_bags after a piece; returns the path of its table, or None if all was done before."""
    environment = {**os.environ, 'PYTHONDEVMODE': ''}  # with it, asyncio would tell that it was stopped
    with subprocess.Popen(command_for(package, '--out', folder, '--workers', '1', recorded), text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                          env=environment) as process:
        piece = wait_for_piece(folder)
        os.killpg(process.pid, signal.SIGSTOP)  # so that it is not done before the other one has failed
        other = annotate(package, folder, recorded, code=1)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        os.killpg(process.pid, signal.SIGCONT)
        output, _ = process.communicate(timeout=WAIT_S)
    if process.returncode == 0:  # it was stopped late, as on a busy machine
        return None
    assert process.returncode == 130
    assert 'Another annotate_bags works in the folder' in other
    assert output == 'annotate_bags: interrupted. The same command continues from here.\n'
    return piece


def test_it_continues_after_an_interruption(package, recorded, done, tmp_path_factory):
    piece, tmp_path = None, None
    while piece is None:
        tmp_path = tmp_path_factory.mktemp('interrupted')
        piece = interrupted(package, recorded, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ['.unit5']
    made = piece.stat().st_mtime_ns
    with subprocess.Popen(command_for(package, '--out', tmp_path, '--workers', '1', recorded)) as process:
        with suppress(FileNotFoundError):  # the pieces have been joined
            while process.poll() is None:
                assert piece.stat().st_mtime_ns == made
        assert process.wait(WAIT_S) == 0
    assert_same(done, tmp_path)
    assert 'is done already' in annotate(package, tmp_path, recorded)
    annotate(package, tmp_path, 'gone.bag', code=1)
    assert_same(done, tmp_path)


def wait_for_piece(folder):
    """Wait until a piece is done; returns the path of its table."""
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        tables = list(folder.glob('.unit5/drive/*/drafts/*/[0-9][0-9][0-9][0-9][0-9][0-9].csv'))
        if tables:
            return tables[0]
        time.sleep(0.02)
    raise AssertionError('no piece was done in time')


def test_broken_bags_are_reported_and_the_others_are_processed(package, recorded, frames, tmp_path):
    with open(recorded, 'rb') as file:
        whole = file.read()
    broken = {'cut.bag': whole[:len(whole) // 2], 'empty.bag': b'', 'text.bag': b'This is no bag.'}
    for name, data in broken.items():
        (tmp_path / name).write_bytes(data)
    with rosbag.Bag(str(tmp_path / 'blind.bag'), 'w') as bag:
        bag.write('/nothing', Header(), rospy.Time(1))
    with rosbag.Bag(str(tmp_path / 'raw.bag'), 'w') as bag:
        header = Header(stamp=rospy.Time(5), frame_id='eye')
        bag.write('/eye/image', image_from_frame(frames[0].image, header), header.stamp)
        bag.write('/eye/image', image_from_frame(frames[0].image, header, 'rgb8'), header.stamp)
    paths = [tmp_path / name for name in (*broken, 'blind.bag', 'gone.bag', 'raw.bag')]
    output = annotate(package, tmp_path / 'out', *paths, code=1)
    for name in (*broken, 'blind.bag', 'gone.bag'):
        assert '%s" cannot be processed: it ' % name in output
    assert 'rosbag reindex' in output and 'it has no images: no topic' in output
    assert 'Traceback' not in output
    assert sorted(path.name for path in (tmp_path / 'out').glob('*.*')) == ['.unit5', 'raw.bag', 'tags.csv']
    assert {row['bag'] for row in rows_of(tmp_path / 'out')} == {'raw.bag'}


def test_each_camera_is_processed_once_whatever_the_names_of_its_topics(package, frames, tmp_path):
    path, header = str(tmp_path / 'many.bag'), Header(stamp=rospy.Time(5), frame_id='eye')
    frame = frames[0].image
    with rosbag.Bag(path, 'w', compression='bz2') as bag:
        for number in range(3):
            stamp = header.stamp + rospy.Duration(number / FRAMES_PER_S)
            bag.write('/eye/camera_info', CameraInfo(width=640, height=480), stamp)
            bag.write('/eye/image', image_from_frame(frame, header, 'rgb8'), stamp)
            bag.write('/eye/image/compressed', compressed_from_frame(frame, header), stamp)
            bag.write('/eye_image', image_from_frame(frame, header), stamp)
            depth = image_from_frame(frame, header)
            depth.encoding = '32FC1'
            bag.write('/depth', depth, stamp)
            bag.write('/depth/compressedDepth', CompressedImage(format='32FC1; compressedDepth', data=b'depth'),
                      stamp)
            bag.write('/front/image/compressed', compressed_from_frame(frame, header), stamp)
    output = annotate(package, tmp_path / 'out', path, '--video', '--exercise', '5_2')
    assert output.count('Bag "%s": ' % path) == 4
    assert '/eye/image and /eye/image/compressed are of the same camera, so only /eye/image is' in output
    assert re.search('frames on /depth are skipped: .*"32FC1"', output)
    assert re.search('frames on /depth/compressedDepth are skipped: .* is a depth image', output)
    assert 'there are no poses for /eye/image, since its camera_info cannot be used: its K is not a' in output
    assert {row['topic'] for row in rows_of(tmp_path / 'out')} == {
        '/eye/image', '/eye_image', '/front/image/compressed'}
    with rosbag.Bag(str(tmp_path / 'out' / 'many.bag')) as bag:
        topics = bag.get_type_and_topic_info().topics
    assert {topic: about.message_count for topic, about in topics.items()} == {
        '/exercise5_2/%s%s' % (what, camera): 3 for what, ending in (
            ('image', '/compressed'), ('tags', ''), ('annotations', ''))
        for camera in ('/eye/image' + ending, '/eye_image' + ending, '/front/image' + ending)}
    assert {path.name for path in (tmp_path / 'out').glob('*.mp4')} == {
        'many.eye.image.mp4', 'many.eye_image.mp4', 'many.front.image.mp4'}


@pytest.mark.parametrize('arguments, words', [
    (['_fit:=wide'], 'fit'), (['_scale:=2'], '"_scale"'), (['ids:=1,2,3,4'], '"ids"'), (['_ids:={a'], '~ids'),
    (['--workers', '0'], '--workers'),
    (['_picture:=no.png'], 'no.png'), (['_wall:=config/wall.yaml'], 'wall.yaml" is damaged, or is none that'),
    (['--piece', '0'], '--piece'),
    (['--scheduler', 'tcp://127.0.0.1:9'], 'tcp://127.0.0.1:9 does not answer')])
def test_wrong_arguments_are_explained(package, recorded, tmp_path, arguments, words):
    output = annotate(package, tmp_path, recorded, *arguments, code=2 if arguments[0][0] == '-' and
                      arguments[0] != '--scheduler' else 1)
    assert words in output and 'Traceback' not in output


def test_a_remembered_wall_is_painted_without_its_tags(package, tmp_path):
    tracker = Tracker()
    follow(tracker, drive(LIVELY, 75, wall=PAINTING, noise=1.0))
    tracker.save_wall(str(tmp_path / 'wall.npz'))
    frames = list(drive(LIVELY, 30, lambda number: PAINTING.area, wall=PAINTING, noise=1.0))
    record(str(tmp_path / 'bare.bag'), [frame.image for frame in frames], 1, 'compressed')
    cv2.imwrite(str(tmp_path / 'red.png'), np.full((20, 30, 3), (0, 0, 255), np.uint8))
    annotate(package, tmp_path / 'out', tmp_path / 'bare.bag', '_wall:=%s' % (tmp_path / 'wall.npz'),
             '_picture:=%s' % (tmp_path / 'red.png'))
    with rosbag.Bag(str(tmp_path / 'out' / 'bare.bag')) as bag:
        painted = [frame_from_compressed(message) for _, message, _ in bag.read_messages([PAINTED])]
    assert len(painted) == len(frames)
    for image, frame in zip(painted, frames):
        x, y = frame.corners.mean(axis=0).astype(int)
        np.testing.assert_allclose(image[y, x], (0, 0, 255), atol=12)


def test_no_bag_is_overwritten(package, recorded, tmp_path):
    (tmp_path / 'bags').mkdir()
    (tmp_path / 'bags' / 'drive.bag').symlink_to(recorded)
    os.link(recorded, str(tmp_path / 'one.bag'))
    (tmp_path / 'here').symlink_to(tmp_path)
    assert 'Give another --out' in annotate(package, tmp_path / 'here', tmp_path / 'one.bag', code=1)
    link, folder = tmp_path / 'bags' / 'drive.bag', os.path.dirname(recorded)
    assert 'Give another --out' in annotate(package, folder, link, code=1)


def test_results_of_other_settings_are_made_again(package, recorded, done, tmp_path):
    annotate(package, tmp_path, recorded, '--exercise', '5.2')
    with rosbag.Bag(str(tmp_path / 'drive.bag')) as bag:
        assert all(topic.startswith('/exercise5_2/') for topic in bag.get_type_and_topic_info().topics)
    annotate(package, tmp_path, recorded)
    assert_same(done, tmp_path)
    os.unlink(str(tmp_path / 'drive.bag'))
    annotate(package, tmp_path, recorded)
    assert_same(done, tmp_path)


def test_what_a_killed_process_left_does_no_harm(package, recorded, done, tmp_path):
    annotate(package, tmp_path, recorded)
    (tmp_path / '.unit5' / '0123456789abcdef.csv').write_text('half of a tab')
    (tmp_path / '.unit5' / 'drive' / 'left').write_text('')
    assert 'is done already' in annotate(package, tmp_path, recorded)
    assert sorted(path.name for path in (tmp_path / '.unit5').iterdir()) == ['.lock', 'drive']
    assert_same(done, tmp_path)
    note, = (tmp_path / '.unit5' / 'drive').glob('*/done.json')
    note.write_text('')  # as after a loss of power
    assert 'is done already' not in annotate(package, tmp_path, recorded)
    assert_same(done, tmp_path)


def test_results_of_other_code_are_made_again(package, frames, tmp_path):
    record(str(tmp_path / 'brief.bag'), [frame.image for frame in frames[:FRAMES_PER_S]], 1, 'compressed')
    for name in 'src', 'nodes':
        shutil.copytree(os.path.join(package, name), str(tmp_path / 'unit5' / name))
    for name in 'package.xml', 'config', 'images':
        (tmp_path / 'unit5' / name).symlink_to(os.path.join(package, name))
    run = [str(tmp_path / 'unit5'), tmp_path / 'out', tmp_path / 'brief.bag', '--exercise', '5.2',
           '--workers', '1']
    assert 'Wrote' in annotate(*run) and 'is done already' in annotate(*run)
    for edited in 'exercise5_2.py', 'aruco_ar/tags/edges.py', 'aruco_ar/compiled/tag_edges.c':
        with open(str(tmp_path / 'unit5' / 'src' / edited), 'a') as code:
            code.write('\n')
        assert 'is done already' not in annotate(*run), edited
    assert 'is done already' in annotate(*run)


def test_the_help_lists_the_exercises_and_the_parameters_of_bags(package):
    output = subprocess.run([sys.executable, package + '/nodes/annotate_bags.py', '--help'],
                            stdout=subprocess.PIPE, text=True, check=True).stdout
    assert '{5.2,5.3,5.4,5.5,5.6}' in output and '5_2 is the same as 5.2' in output
    listed = re.findall(r'^  _(\w+) +(\S+)', output, re.MULTILINE)
    assert dict(listed)['confidence'] == '0.2'
    only_of_nodes = {'image_transport', 'folder', 'scale', 'areas', 'camera_info', 'tag_frame', 'wall_frame',
                     'robot_frame'}
    assert {name for name, _ in listed} == set(ros_values(BagSettings())) - only_of_nodes
