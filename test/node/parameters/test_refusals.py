"""What is refused is told to the one who asked for it, though others ask at the same time."""
import asyncio
import threading
from types import SimpleNamespace

import pytest
from aruco_ar import InputError
from aruco_node.page import remote
from aruco_node.ros_internals import reconfigure_server
from dynamic_reconfigure.msg import Config, StrParameter
from rig.processes.started import WAIT_S


def config_of(**values):
    return Config(strs=[StrParameter(*item) for item in values.items()])


def test_dynparam_is_told_its_own_refusal(monkeypatch):
    inside, go_on = threading.Event(), threading.Event()

    class Checked(reconfigure_server.CheckedServer):
        def __init__(self):
            super().__init__(None, None)

        def check_names(self, names):
            pass

        def update_configuration(self, changes):
            if changes['fit'] == 'bad':
                self.refuse('Bad.')
                inside.set()
                assert go_on.wait(WAIT_S)  # the other request is answered meanwhile
            return changes
    monkeypatch.setattr(reconfigure_server.Server, '__init__', lambda *_: None)
    monkeypatch.setattr(reconfigure_server, 'encode_config', dict)
    monkeypatch.setattr(reconfigure_server, 'sender', lambda *_: '/dynparam_1')
    server, told = Checked(), []

    def ask():
        with pytest.raises(Exception, match='Bad. Nothing is changed.') as refused:
            server._set_callback(SimpleNamespace(config=config_of(fit='bad')))
        told.append(refused.value)
    asking = threading.Thread(target=ask)
    asking.start()
    assert inside.wait(WAIT_S)
    assert server._set_callback(SimpleNamespace(config=config_of(fit='cover'))) == {'fit': 'cover'}
    go_on.set()
    asking.join(WAIT_S)
    assert len(told) == 1


def test_a_browser_is_told_only_that_its_own_value_is_refused(monkeypatch):
    begun, go_on, asked = threading.Event(), threading.Event(), []

    def service(config):
        asked.append({item.name: item.value for item in config.strs})
        if len(asked) == 1:
            begun.set()
            assert go_on.wait(WAIT_S)
        return SimpleNamespace(config=config_of(fit='cover', ids='any', dictionary='A'))  # it keeps its ids
    monkeypatch.setattr(remote.rospy, 'Subscriber', lambda *_: None)
    monkeypatch.setattr(remote.rospy, 'ServiceProxy', lambda *_: service)

    async def set_all():
        node = remote.RemoteParameters('/node', None)
        first = asyncio.ensure_future(node.set(fit='cover'))
        await asyncio.get_event_loop().run_in_executor(None, begun.wait, WAIT_S)
        others = [asyncio.ensure_future(node.set(**each)) for each in ({'ids': '1,2'}, {'dictionary': 'A'})]
        await asyncio.sleep(0)  # these two wait for the first one, and are sent together
        go_on.set()
        return await asyncio.gather(first, *others, return_exceptions=True)
    first, refused, taken = asyncio.run(set_all())
    assert asked == [{'fit': 'cover'}, {'ids': '1,2', 'dictionary': 'A'}]
    assert first is taken is None
    assert isinstance(refused, InputError) and '/node refuses "1,2".' in str(refused)
