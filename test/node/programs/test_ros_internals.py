"""The private parts of ROS that the package uses still exist; without them, nodes warn, and still work."""
import io
import re
import socket
import struct
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress
from types import SimpleNamespace
from unittest import mock

import genpy
import pytest
import rosbag
import rospy
from aruco_ar import InputError
from aruco_node.ros_internals import (
    admission,
    indexed_bag,
    reconfigure_server,
    registration,
    shutdown,
    subscribers,
    tf,
    warn_of_other,
)
from aruco_node.ros_internals.indexed_bag import IndexedBag, forget_written
from aruco_node.ros_internals.subscribers import tolerant
from dynamic_reconfigure.msg import Config, DoubleParameter, GroupState
from dynamic_reconfigure.server import Server
from dynamic_reconfigure.srv import Reconfigure
from rig.processes.started import WAIT_S
from rospy.exceptions import TransportException
from rospy.impl import tcpros_base
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from std_msgs.msg import Header, UInt8
from tf2_msgs.msg import TFMessage


@pytest.fixture(autouse=True)
def warnings():
    warn_of_other.cache_clear()  # what other tests have said
    with mock.patch('rospy.logwarn') as said:
        yield said


def assert_warned_once(warnings, package, words):
    said, = warnings.call_args_list
    assert re.match('This %s is not one that unit5 knows. .*%s' % (package, words), said[0][0] % said[0][1:])


@pytest.fixture
def server(monkeypatch):
    """rospy's server of connections, without a node."""
    made = tcpros_base.TCPROSServer()
    monkeypatch.setattr(tcpros_base, '_tcpros_server', made)
    # Whoever asks for a topic gets this reply, and the connection is closed.
    made.topic_connection_handler = lambda connection, address, header: 'no topic here'
    made.start_server()
    yield made
    made.shutdown()


FIELD = b'topic=/any'
HEADER = struct.pack('<II', len(FIELD) + 4, len(FIELD)) + FIELD


def ask_for_topic(connection):
    connection.sendall(HEADER)
    return connection.recv(100)


def assert_hung_up(connection):
    connection.settimeout(WAIT_S)
    with suppress(ConnectionResetError):  # there are bytes that nobody has read
        assert connection.recv(100) == b''


@pytest.mark.parametrize('is_admitted_alone', [True, False])
def test_a_silent_connection_does_not_lock_out_others(server, is_admitted_alone, warnings):
    if is_admitted_alone:
        admission.admit_concurrently()
    address = 'localhost', server.tcp_ros_server.port
    with socket.create_connection(address), socket.create_connection(address, timeout=WAIT_S) as other:
        if is_admitted_alone:
            assert b'no topic here' in ask_for_topic(other)
        else:  # the fault of rospy; if this fails, admission.py is no longer needed
            other.settimeout(0.5)
            with pytest.raises(socket.timeout):
                ask_for_topic(other)
    warnings.assert_not_called()


def test_a_connection_that_was_hung_up_is_not_admitted_after_the_one_that_replaces_it(server):
    admitted = []

    def note(connection, address, header):
        admitted.append(address)
        return 'noted'
    server.topic_connection_handler = note
    admission.admit_concurrently()
    address = 'localhost', server.tcp_ros_server.port
    with socket.create_connection(address) as first, socket.create_connection(address, WAIT_S) as second:
        first.sendall(HEADER[:-1])
        addresses = [second.getsockname()]
        assert b'noted' in ask_for_topic(second)
        first.sendall(HEADER[-1:], socket.MSG_MORE)  # arrives together with the end
        first.shutdown(socket.SHUT_WR)
        assert_hung_up(first)
    assert admitted == addresses


@pytest.mark.parametrize('sent', [b'POST / HTTP/1.1\r\n', b'\1', b''])
def test_what_sends_no_header_is_hung_up(server, sent, monkeypatch):
    monkeypatch.setattr(admission, 'HEADER_S', 0.1)
    admission.admit_concurrently()
    with socket.create_connection(('localhost', server.tcp_ros_server.port), WAIT_S) as connection:
        connection.sendall(sent)
        assert_hung_up(connection)


def test_another_server_causes_a_warning(monkeypatch, warnings):
    monkeypatch.setattr(tcpros_base, '_tcpros_server', SimpleNamespace())
    for _ in range(2):
        admission.admit_concurrently()
    assert_warned_once(warnings, 'rospy', 'can lock out all others')


def test_more_is_pending_after_bytes_have_arrived(warnings):
    # The test below checks that rospy.Subscriber has these attributes.
    here, there = socket.socketpair()
    with here, there:
        subscriber = SimpleNamespace(impl=SimpleNamespace(connections=[SimpleNamespace(socket=here)]))
        assert not subscribers.is_more_pending(subscriber)
        there.send(b'1')
        assert subscribers.is_more_pending(subscriber)
    assert not subscribers.is_more_pending(subscriber)  # closed
    assert not subscribers.is_more_pending(None)
    warnings.assert_not_called()


@pytest.mark.parametrize('subscriber', [
    SimpleNamespace(), SimpleNamespace(impl=SimpleNamespace()),
    SimpleNamespace(impl=SimpleNamespace(connections=[SimpleNamespace()]))])
def test_nothing_is_pending_for_another_subscriber_and_a_warning_says_so(subscriber, warnings):
    for _ in range(2):
        assert not subscribers.is_more_pending(subscriber)
    assert_warned_once(warnings, 'rospy', 'results come late')


def test_a_subscriber_has_connections_with_sockets(warnings):
    subscriber = rospy.Subscriber('/topic', UInt8)
    impl = subscriber.impl
    assert impl.connections == []
    impl.connections = [TCPROSTransport(TCPROSSub('/topic', UInt8), '/topic')]
    assert impl.connections[0].socket is None  # not yet connected
    assert not subscribers.is_more_pending(subscriber)
    subscriber.unregister()
    assert subscriber.impl is None and not impl.connections
    assert not subscribers.is_more_pending(subscriber)
    assert not subscribers.is_more_pending(SimpleNamespace(impl=impl))
    warnings.assert_not_called()


@pytest.mark.parametrize('is_tolerant', [True, False])
def test_a_message_that_cannot_be_read_does_not_hold_up_those_after_it(is_tolerant):
    good = io.BytesIO()
    Header(seq=3).serialize(good)
    data = b''.join(struct.pack('<I', len(each)) + each for each in (b'bad', b'', good.getvalue()))
    kind = tolerant(Header) if is_tolerant else Header
    transport = TCPROSTransport(TCPROSSub('/topic', kind), '/topic')
    here, there = socket.socketpair()
    with here, there, mock.patch('rospy.logerr') as said:
        transport.set_socket(here, 'there')
        there.sendall(data)
        if is_tolerant:
            assert [message.seq for message in transport.receive_once()] == [0, 0, 3]
            assert said.call_count == 1
        else:
            for _ in range(2):  # the fault of rospy; if this fails, tolerant is no longer needed
                with pytest.raises(TransportException, match='DeserializationError'):
                    transport.receive_once()


def test_a_node_registers_all_its_topics_and_services(monkeypatch):
    assert registration.IS_KNOWN
    topics = registration.get_topic_manager()
    services = registration.get_service_manager()
    registered = []
    listener = registration.get_registration_listeners()
    monkeypatch.setattr(services, 'get_services', lambda: [('/first', 'uri'), ('/last', 'uri')])
    monkeypatch.setattr(topics, 'get_publications', lambda: [('/image', 'kind')])
    monkeypatch.setattr(topics, 'get_subscriptions', lambda: [('/camera', 'kind')])
    monkeypatch.setattr(listener, 'notify_added', lambda name, what, kind: registered.append((name, kind)))
    registration._register()
    kinds = registration.Registration
    assert registered == [('/first', kinds.SRV), ('/image', kinds.PUB), ('/camera', kinds.SUB),
                          ('/last', kinds.SRV)]


@pytest.mark.parametrize('name', ['lock', 'get_publications', 'get_subscriptions'])
def test_a_topic_manager_has_the_private_attribute(name):
    assert hasattr(registration.get_topic_manager(), name)


@pytest.mark.parametrize('name', ['lock', 'get_services'])
def test_a_service_manager_has_the_private_attribute(name):
    assert hasattr(registration.get_service_manager(), name)


def test_another_rospy_causes_a_warning_and_nothing_is_watched(monkeypatch, warnings):
    monkeypatch.setattr(registration, 'IS_KNOWN', False)
    before = threading.active_count()
    for _ in range(2):
        registration.keep_registered()
    assert threading.active_count() == before
    assert_warned_once(warnings, 'rospy', 'restart this node, too')


def test_only_transforms_of_others_are_received(warnings):
    frames = object.__new__(tf.OthersFrames)
    frames.tf_sub = frames.tf_static_sub = mock.Mock()
    with mock.patch('rospy.get_name', return_value='/we'), \
            mock.patch('tf2_ros.TransformListener.callback') as taken:
        for header in {'callerid': '/we'}, {'callerid': '/others'}:
            message = TFMessage()
            message._connection_header = header
            frames.callback(message)
        assert taken.call_count == 1
        warnings.assert_not_called()
        for _ in range(2):  # of another rospy
            frames.callback(TFMessage())
    assert taken.call_count == 3
    assert_warned_once(warnings, 'rospy', 'its own TF frames, too')


def test_listeners_to_tf_frames_are_counted(warnings):
    broadcaster = tf.Broadcaster()
    connections = broadcaster.pub_tf.impl.connections
    assert not broadcaster.is_heard()
    connections.append(mock.Mock())
    assert broadcaster.is_heard() and not broadcaster.is_heard(own=1)
    connections.clear()
    warnings.assert_not_called()


def test_another_broadcaster_is_always_heard_and_a_warning_says_so(warnings):
    broadcaster = tf.Broadcaster()
    del broadcaster.pub_tf
    for _ in range(2):
        assert broadcaster.is_heard()
    assert_warned_once(warnings, 'tf2_ros', 'works even if nobody listens')


def test_ros_is_ending_before_it_has_shut_down():
    # If rospy.is_shutdown() is true here, too, shutdown.py is no longer needed.
    script = 'import rospy; from aruco_node.ros_internals.shutdown import is_ending; print(is_ending()); ' \
             'rospy.on_shutdown(lambda: print(is_ending(), rospy.is_shutdown())); rospy.signal_shutdown("over")'
    done = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True)
    assert done.stdout == 'False\nTrue False\n', done


@pytest.mark.parametrize('is_shutdown', [True, False])
def test_another_rospy_is_ending_when_it_has_shut_down(is_shutdown, warnings, monkeypatch):
    monkeypatch.delattr('rospy.core.is_shutdown_requested')
    monkeypatch.setattr('rospy.is_shutdown', lambda: is_shutdown)
    for _ in range(2):
        assert shutdown.is_ending() == is_shutdown
    assert_warned_once(warnings, 'rospy', 'say that it failed')


@contextmanager
def checked_server():
    """A context manager with a CheckedServer without a running ROS."""
    with mock.patch.multiple('dynamic_reconfigure.server.Server', __init__=mock.Mock(return_value=None),
                             update_configuration=lambda self, wanted: wanted):
        server = reconfigure_server.CheckedServer('description', None)
        server.check_names = lambda names: None
        yield server


def check_request_with_unknown_group():
    """Send a request with an unknown group to a CheckedServer."""
    with checked_server() as server:
        request = SimpleNamespace(config=Config(doubles=[DoubleParameter('noise', 200.0)],
                                                groups=[GroupState(name='of nobody')]))
        assert [(each.name, each.value) for each in server._set_callback(request).doubles] == [('noise', 200.0)]


def test_requests_with_unknown_groups_are_accepted(warnings):
    for name in reconfigure_server.PRIVATE:
        assert callable(getattr(Server, name))
    check_request_with_unknown_group()
    warnings.assert_not_called()


def test_another_dynamic_reconfigure_causes_a_warning(monkeypatch, warnings):
    monkeypatch.setattr(reconfigure_server, 'PRIVATE', ['_not_there'])
    for _ in range(2):
        check_request_with_unknown_group()
    assert_warned_once(warnings, 'dynamic_reconfigure', 'clipped without a word')


def test_only_dynparam_sees_a_refusal_as_a_failure(warnings):
    with checked_server() as server, mock.patch('rospy.logerr'):
        server.check_names = mock.Mock(side_effect=InputError('No.'))
        request = Reconfigure._request_class()
        request._connection_header = {'callerid': '/rqt'}
        server._set_callback(request)
        request._connection_header = {'callerid': '/dynparam_1'}
        with pytest.raises(rospy.ServiceException, match='No. Nothing is changed.'):
            server._set_callback(request)
        warnings.assert_not_called()
        for _ in range(2):  # of another rospy
            server._set_callback(Reconfigure._request_class())
    assert_warned_once(warnings, 'rospy', 'does not print why')


@pytest.fixture
def bag(tmp_path):
    """The path of a bag with 100 messages per topic, one per second, in many chunks."""
    path = str(tmp_path / 'long.bag')
    with rosbag.Bag(path, 'w', chunk_threshold=256) as written:
        for second in range(1, 101):
            written.write('/count', UInt8(second), genpy.Time(second))
            written.write('/header', Header(seq=second), genpy.Time(second))
            forget_written(written)
            assert not any(written._connection_indexes.values())
    return path


def test_another_rosbag_causes_a_warning_when_a_bag_is_written(warnings):
    for _ in range(2):
        forget_written(SimpleNamespace())
    assert_warned_once(warnings, 'rosbag', 'Writing a long bag takes much memory')


@pytest.mark.parametrize('is_known, lacking, value', [
    (True, None, None), (False, 'PRIVATE', ['_not_there']), (False, 'PRIVATE_OF_READER', '_not_there')])
def test_a_part_of_a_bag_can_be_read_alone(bag, is_known, lacking, value, monkeypatch, warnings):
    if lacking:
        monkeypatch.setattr(indexed_bag, lacking, value)
        IndexedBag(bag).close()
    part = IndexedBag(bag)
    if is_known:
        warnings.assert_not_called()
    else:
        assert_warned_once(warnings, 'rosbag', 'Reading a long bag takes much time and memory')
    assert part.begin() == genpy.Time(1)
    assert part.topics() == {'/count': 'std_msgs/UInt8', '/header': 'std_msgs/Header'}
    assert sorted(time.secs for _, time in part.times(['/count'])) == list(range(1, 101))
    for begin in 10, 50, 3:
        found = list(part.messages(['/count'], genpy.Time(begin), genpy.Time(begin + 5)))
        assert [message.data for _, message, _ in found] == list(range(begin, begin + 6))
        if is_known:  # the index in memory has only a few more messages than these
            assert sum(map(len, part._bag._connection_indexes.values())) < 40
    part.close()
