"""MCAP files: read in parts as bags are, written by annotate_bags, and refused with a reason."""
import re
import subprocess
import sys

import genpy
import numpy as np
import pytest
import rosbag
import rospy
from aruco_ar import InputError
from aruco_bags import pieces
from aruco_bags.bag_reader import opened, pieces_of
from aruco_bags.mcap_bag import McapBag
from aruco_node.messages.annotations import kinds
from aruco_node.messages.images import frame_from_compressed
from aruco_node.ros_internals.indexed_bag import IndexedBag
from benchmark.ros.bags import BEGIN_S, record
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer
from rig.accuracy.drives import FRAMES_PER_S, LIVELY, WALL, drive
from rig.processes.started import WAIT_S, program
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header, String, UInt8

SECONDS, PIECE_S = 3, 1
CAMERA = '/camera/rgb/image_raw'
pytestmark = pytest.mark.xdist_group('mcap')  # in one process, which makes a bag once


def converted(bag, path, profile='ros1', encoding='ros1', **options):
    """Write the messages of a bag into an MCAP file, as mcap convert does; returns its path."""
    numbers = {}
    with rosbag.Bag(str(bag)) as source, open(str(path), 'wb') as file:
        writer = Writer(file, **options)
        writer.start(profile)
        for topic, (name, data, _, _, kind), time in source.read_messages(raw=True):
            if topic not in numbers:
                schema = writer.register_schema(name, encoding + 'msg', kind._full_text.encode())
                numbers[topic] = writer.register_channel(topic, encoding, schema)
            writer.add_message(numbers[topic], time.to_nsec(), data, time.to_nsec())
        writer.finish()
    return str(path)


def annotate(*arguments, code=0):
    """Run annotate_bags, which must end with this exit code; returns what it prints."""
    done = subprocess.run([sys.executable, program('annotate_bags.py'), '--piece', str(PIECE_S),
                           *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=WAIT_S)
    assert done.returncode == code and 'Traceback' not in done.stdout, done.stdout
    return done.stdout


@pytest.fixture(scope='module')
def small(tmp_path_factory):
    """The path of a bag with 100 messages on each of two topics, not in the order of time."""
    path = str(tmp_path_factory.mktemp('small') / 'small.bag')
    with rosbag.Bag(path, 'w') as bag:
        for second in [*range(51, 101), *range(1, 51)]:
            bag.write('/count', UInt8(second), genpy.Time(second, 7))
            bag.write('/header', Header(seq=second), genpy.Time(second, 7))
    return path


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """The path of a bag with the frames of a lively drive."""
    path = str(tmp_path_factory.mktemp('recorded') / 'drive.bag')
    record(path, [frame.image for frame in drive(LIVELY, SECONDS * FRAMES_PER_S, noise=2.0)], SECONDS,
           'compressed')
    return path


@pytest.fixture(scope='module')
def done(recorded, tmp_path_factory):
    """The folder with what is made of that bag."""
    folder = tmp_path_factory.mktemp('done')
    annotate(recorded, '--out', folder, '--workers', '1')
    return folder


def contents(path):
    """[(topic, type, bytes, time)] of a bag or an MCAP file, in order of time; read by their own libraries."""
    if path.suffix == '.bag':
        with rosbag.Bag(str(path)) as bag:
            return sorted((topic, message[0], message[1], time.to_nsec())
                          for topic, message, time in bag.read_messages(raw=True))
    with open(str(path), 'rb') as file:
        return sorted((channel.topic, schema.name, message.data, message.log_time)
                      for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages())


@pytest.mark.parametrize('options', [
    {'compression': CompressionType.NONE}, {'compression': CompressionType.LZ4}, {}, {'chunk_size': 200},
    {'use_chunking': False}, {'index_types': IndexType.ALL & ~IndexType.MESSAGE},
    {'use_statistics': False, 'chunk_size': 200}])
def test_a_file_is_read_as_the_bag_with_the_same_messages(small, tmp_path, options):
    bag, other = IndexedBag(small), McapBag(converted(small, tmp_path / 'small.mcap', **options))
    assert other.topics() == bag.topics() == {'/count': 'std_msgs/UInt8', '/header': 'std_msgs/Header'}
    assert other.begin() == bag.begin() == genpy.Time(1, 7)
    for topics in ['/count'], ['/count', '/header'], ['/none']:
        assert sorted(other.times(topics)) == sorted(bag.times(topics))
    for begin, end in ((1, 200), (10, 15), (50, 52), (200, 300)):
        found = list(other.messages(['/count'], genpy.Time(begin, 7), genpy.Time(end, 7)))
        assert [(topic, message.data, time) for topic, message, time in found] == [
            ('/count', second, genpy.Time(second, 7)) for second in range(begin, min(end, 100) + 1)]
        assert all(isinstance(message, genpy.Message) and message._type == 'std_msgs/UInt8'
                   for _, message, _ in found)
    bag.close()
    other.close()


def test_a_part_is_read_without_the_rest_of_the_file(small, tmp_path):
    path = converted(small, tmp_path / 'small.mcap', chunk_size=200)
    file = McapBag(path)
    with open(path, 'r+b') as written:  # spoil all but the chunks with the messages that are asked for
        for chunk in file._chunks:
            if chunk.message_start_time // 10**9 not in range(8, 17):
                written.seek(chunk.chunk_start_offset)
                written.write(bytes(chunk.chunk_length))
    assert [message.data for _, message, _ in file.messages(['/count'], genpy.Time(10), genpy.Time(15))] == \
        list(range(10, 15))
    file.close()


def test_the_result_is_that_of_the_bag_whatever_the_number_of_workers(recorded, done, tmp_path):
    path = converted(recorded, tmp_path / 'drive.mcap', chunk_size=50000)
    annotate(path, '--out', tmp_path / 'out', '--workers', '3', '--video')
    assert contents(tmp_path / 'out' / 'drive.mcap') == contents(done / 'drive.bag')
    table = (tmp_path / 'out' / 'tags.csv').read_text()
    assert table.replace('drive.mcap', 'drive.bag') == (done / 'tags.csv').read_text()
    assert (tmp_path / 'out' / 'drive.mp4').stat().st_size > 10000
    annotate(recorded, '--out', tmp_path / 'on_demand', '--mcap', '--workers', '1')
    assert (tmp_path / 'on_demand' / 'drive.mcap').read_bytes() == \
        (tmp_path / 'out' / 'drive.mcap').read_bytes()
    assert not (tmp_path / 'on_demand' / 'drive.bag').exists()
    assert 'is done already' in annotate(path, '--out', tmp_path / 'out', '--video')


def test_viewers_find_images_marks_and_calibration_of_each_frame(recorded, tmp_path):
    annotate(recorded, '--out', tmp_path, '--mcap')
    kind_of = {'std_msgs/String': String, 'foxglove_msgs/ImageAnnotations': kinds().ImageAnnotations,
               'sensor_msgs/CameraInfo': CameraInfo}
    marks, infos, stamps = {}, {}, []
    with open(str(tmp_path / 'drive.mcap'), 'rb') as file:
        reader = make_reader(file)
        assert reader.get_header().profile == 'ros1'
        for schema, channel, message in reader.iter_messages():
            assert (channel.message_encoding, schema.encoding) == ('ros1', 'ros1msg')
            if schema.name in kind_of:
                kind = kind_of[schema.name]
                assert (channel.metadata['md5sum'], schema.data.decode()) == (kind._md5sum, kind._full_text)
                found = kind().deserialize(message.data)
                topic = channel.topic.replace(CAMERA, '')
                if topic == '/exercise5_6/annotations':
                    marks[message.log_time] = found
                elif topic == '/exercise5_6/camera_info':
                    infos[message.log_time] = found
            elif 'image/' in channel.topic:
                stamps.append(message.log_time)
    assert len(stamps) == SECONDS * FRAMES_PER_S and set(marks) == set(infos) == set(stamps)
    frames = [frame.corners for frame in drive(LIVELY, SECONDS * FRAMES_PER_S, noise=2.0)]
    whole = 0  # frames with a text at each tag
    for stamp in stamps:
        texts, info = marks[stamp].texts, infos[stamp]
        assert (info.header.stamp.to_nsec(), info.width, info.header.frame_id) == (stamp, 640, 'eye')
        assert all(text.timestamp.to_nsec() == stamp for text in texts)
        # The corners of the area are the centers of the tags.
        corners = frames[round((stamp / 1e9 - BEGIN_S) * FRAMES_PER_S)]
        centers = {str(tag_id): corner for tag_id, corner in zip(WALL.area, corners)}
        for text in texts:
            place = text.position.x - 0.5, text.position.y - 0.5
            np.testing.assert_allclose(place, centers[text.text], atol=1)
        whole += {text.text for text in texts} == set(centers)
    assert whole > 0.9 * len(stamps)


def test_files_that_cannot_be_read_are_named_with_the_reason(recorded, small, tmp_path):
    whole = converted(recorded, tmp_path / 'whole.mcap')
    with open(whole, 'rb') as file:
        data = file.read()
    spoiled = data[:5000] + bytes(100) + data[5100:]
    for name, part in (('cut', data[:len(data) // 2]), ('end', data[:-3]), ('short', data[:20]),
                       ('head', data[:8]), ('text', b'no'), ('spoiled', spoiled)):
        (tmp_path / (name + '.mcap')).write_bytes(part)
    converted(small, tmp_path / 'blind.mcap')
    converted(small, tmp_path / 'two.mcap', profile='ros2', encoding='cdr')
    with open(str(tmp_path / 'none.mcap'), 'wb') as file:
        writer = Writer(file, index_types=IndexType.NONE, use_summary_offsets=False, use_statistics=False,
                        repeat_channels=False, repeat_schemas=False)
        writer.start('ros1')
        writer.finish()
    names = ['cut', 'end', 'short', 'head', 'text', 'spoiled', 'blind', 'two', 'none', 'gone']
    output = annotate(*(tmp_path / (name + '.mcap') for name in names), '--out', tmp_path / 'out', code=1)
    for name in names:
        said = re.findall(r'/%s\.mcap" cannot be processed: (it.*)' % name, output)
        assert len(said) == 1, (name, output)
        if name in ('cut', 'end', 'short', 'head', 'none'):
            assert 'it has no index; perhaps' in said[0] and 'mcap recover' in said[0]
    assert 'it has no images: no topic' in output
    assert 'its messages are not of ROS 1: their encoding is cdr. Give a recording of ROS 1.' in output
    assert sorted(path.name for path in (tmp_path / 'out').glob('*')) == ['.unit5', 'tags.csv']


@pytest.mark.parametrize('arguments, words', [
    (['some.bag', '--mcap'], r'Or leave out --mcap\.'), (['some.mcap'], r'Or leave out the MCAP files\.'),
    (['some.mcap', 'other.bag', '--mcap'], r'Or leave out --mcap and the MCAP files\.')])
def test_only_mcap_needs_its_library(package, tmp_path, arguments, words):
    start = 'import sys; sys.modules["mcap"] = None; import annotate_bags; annotate_bags.main(sys.argv[1:])'
    done = subprocess.run([sys.executable, '-c', start, *arguments, '--out', str(tmp_path)],
                          cwd=package + '/nodes', stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=WAIT_S)
    assert done.returncode == 1 and 'Traceback' not in done.stdout
    assert re.search('annotate_bags: unit5 needs mcap 1.6 or later, .*pip install "mcap>=1.6,<2". ' + words,
                     done.stdout), done.stdout


def test_a_bag_and_an_mcap_file_of_one_name_need_two_folders(small, tmp_path):
    path = converted(small, tmp_path / 'small.mcap')
    output = annotate(small, path, '--out', tmp_path / 'out', code=1)
    assert 'The output of "%s" and of "%s" would have the same name. Run the command for each of them' % (
        small, path) in output


def test_a_video_that_cannot_be_made_is_named_and_the_input_stays_open(recorded, done, tmp_path, monkeypatch):
    def fail(message):
        raise ValueError('no\npicture')
    output, topic = str(done / 'drive.bag'), '/exercise5_6/image%s/compressed' % CAMERA
    monkeypatch.setattr(pieces, 'frame_from_compressed', fail)
    with opened(recorded) as before:
        pass
    with pytest.raises(InputError, match=re.escape(
            'the video "drive.mp4" cannot be made of the output "%s" (no picture). Run' % output)):
        pieces.make_video(output, topic, str(tmp_path / 'draft.mp4'), 'drive.mp4')
    with opened(recorded) as after:
        assert after is before


def test_an_mcap_file_under_another_name_is_read(small, recorded, tmp_path, monkeypatch):
    path = converted(recorded, tmp_path / 'drive.bag')
    assert {piece.topic for piece in pieces_of(path)[0]} == {CAMERA + '/compressed'}
    with opened(path) as file:
        _, message, time = next(file.messages([CAMERA + '/compressed'], rospy.Time(), rospy.Time(10**9)))
    assert time.to_sec() == BEGIN_S and frame_from_compressed(message).shape == (480, 640, 3)
    monkeypatch.setitem(sys.modules, 'mcap', None)
    with pytest.raises(InputError, match=r'needs mcap .* Or convert it to a bag\.'), \
            opened(converted_copy(path, tmp_path)):
        pass


def converted_copy(path, folder):
    """A copy of a file, which has not been opened yet."""
    copy = folder / 'copy.bag'
    with open(path, 'rb') as file:
        copy.write_bytes(file.read())
    return str(copy)
