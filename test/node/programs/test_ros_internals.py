"""The private parts of ROS that the package uses still exist; without them, nodes warn, and still work."""
import socket
import struct
import threading
from types import SimpleNamespace
from unittest import mock

import genpy
import pytest
import rosbag
from aruco_node.ros_internals import (
    admission,
    indexed_bag,
    newest,
    reconfigure_server,
    registration,
    tf_listener,
)
from aruco_node.ros_internals.indexed_bag import IndexedBag, forget_written
from dynamic_reconfigure.msg import Config, DoubleParameter, GroupState
from dynamic_reconfigure.server import Server
from rospy.impl import tcpros_base
from std_msgs.msg import Header, UInt8
from tf2_msgs.msg import TFMessage

WAIT_S = 20


@pytest.fixture
def warnings():
    with mock.patch('rospy.logwarn') as said:
        yield said


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


def ask_for_topic(connection):
    field = b'topic=/any'
    connection.sendall(struct.pack('<II', len(field) + 4, len(field)) + field)
    return connection.recv(100)


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


def test_another_server_causes_a_warning(monkeypatch, warnings):
    monkeypatch.setattr(tcpros_base, '_tcpros_server', SimpleNamespace())
    admission.admit_concurrently()
    assert 'can lock out all others' in warnings.call_args[0][0]


def test_more_is_pending_after_bytes_have_arrived():
    # The test below checks that rospy.Subscriber has these attributes.
    here, there = socket.socketpair()
    with here, there:
        subscriber = SimpleNamespace(impl=SimpleNamespace(connections=[SimpleNamespace(socket=here)]))
        assert not newest.is_more_pending(subscriber)
        there.send(b'1')
        assert newest.is_more_pending(subscriber)
    assert not newest.is_more_pending(subscriber)  # closed
    assert not newest.is_more_pending(None)
    assert not newest.is_more_pending(SimpleNamespace())


def test_a_subscriber_has_connections_with_sockets():
    from rospy.impl.tcpros_base import TCPROSTransport
    from rospy.topics import _SubscriberImpl
    assert _SubscriberImpl('/topic', UInt8).connections == []
    transport = TCPROSTransport(tcpros_base.TCPROSTransportProtocol('/topic', UInt8), '/topic')
    assert hasattr(transport, 'socket')


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
    registration.keep_registered()
    assert threading.active_count() == before
    assert 'restart this node, too' in warnings.call_args[0][0]


def test_only_transforms_of_others_are_received():
    frames = object.__new__(tf_listener.OthersFrames)
    frames.tf_sub = frames.tf_static_sub = mock.Mock()
    with mock.patch('rospy.get_name', return_value='/we'), \
            mock.patch('tf2_ros.TransformListener.callback') as taken:
        for header in {'callerid': '/we'}, {'callerid': '/others'}, None:
            message = TFMessage()
            if header:
                message._connection_header = header
            frames.callback(message)
    assert taken.call_count == 2


def check_request_with_unknown_group():
    """Send a request with an unknown group to a CheckedServer without a running ROS."""
    with mock.patch.multiple('dynamic_reconfigure.server.Server', __init__=mock.Mock(return_value=None),
                             update_configuration=lambda self, wanted: wanted):
        server = reconfigure_server.CheckedServer('description', None)
        server.check_names = lambda names: None
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
    check_request_with_unknown_group()
    assert 'clipped without a word' in warnings.call_args[0][0]


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


@pytest.mark.parametrize('is_known', [True, False])
def test_a_part_of_a_bag_can_be_read_alone(bag, is_known, monkeypatch):
    if not is_known:
        monkeypatch.setattr(indexed_bag, 'PRIVATE', ['_not_there'])
    part = IndexedBag(bag)
    assert part.begin() == genpy.Time(1)
    assert part.topics() == {'/count': 'std_msgs/UInt8', '/header': 'std_msgs/Header'}
    assert sorted(time.secs for _, time in part.times(['/count'])) == list(range(1, 101))
    for begin in 10, 50, 3:
        found = list(part.messages(['/count'], genpy.Time(begin), genpy.Time(begin + 5)))
        assert [message.data for _, message, _ in found] == list(range(begin, begin + 6))
        if is_known:  # the index in memory has only a few more messages than these
            assert sum(map(len, part._bag._connection_indexes.values())) < 40
    part.close()
