"""The server of dynamic_reconfigure, for parameters that are checked elsewhere.

Symptom: dynamic_reconfigure's own server starts with unchecked values from the parameter server. It clips a
number beyond its bounds without a word. It fails for a group that it does not know. It waits forever if the
master hangs.
Private: the methods of ``dynamic_reconfigure.server.Server`` in PRIVATE, which are overridden. Without them,
parameters can be changed, but with these symptoms. Also ``_connection_header`` of a request, without which
dynparam is not told that it is refused.
Seen with: dynamic_reconfigure 1.7, rospy 1.15 and 1.17. It can go when the server has a hook before and after a
change.
"""
import threading

import rospy
from aruco_ar.base.errors import InputError
from dynamic_reconfigure.encoding import encode_config
from dynamic_reconfigure.server import Server

from . import sender, warn_of_other
from .master import ask

# dynparam prints nothing about an answer, only about a service that fails. rqt_reconfigure must not see such a
# failure: it would change no parameter of this node from then on.
DYNPARAM = '/dynparam_'
PRIVATE = '_copy_from_parameter_server', '_copy_to_parameter_server', '_set_callback', '_clamp'


class CheckedServer(Server):
    """Offers the parameters of a description. A subclass has their values, and refuses what is not allowed."""

    def __init__(self, description, on_change):
        """``description``, ``on_change``: the type and the callback that Server takes."""
        if not all(hasattr(Server, name) for name in PRIVATE):
            warn_of_other('dynamic_reconfigure', 'Numbers beyond their bounds may be clipped without a word.')
        self._request = threading.local()  # each request comes in a thread of its own
        super().__init__(description, on_change)

    def live_values(self):
        """{name: value} of the parameters as they are now."""
        raise NotImplementedError

    def check_names(self, names):
        """Raise InputError unless all of these are names of parameters."""
        raise NotImplementedError

    def _copy_from_parameter_server(self):
        """Start with the values that have been checked, not with what the parameter server has."""
        self.config.update(self.live_values())

    def _copy_to_parameter_server(self):
        try:
            for name, value in self.live_values().items():
                ask('setParam', rospy.resolve_name('~' + name), value)
        except InputError as error:
            rospy.logwarn('%s The node uses the changed parameters all the same.', error)

    def _set_callback(self, request):
        """Answer a request, a Reconfigure, with all values after it. Its groups are ignored: there are none.

        If it is refused, dynparam is sent the reason instead.
        """
        config = request.config
        self._request.refusal = None
        wanted = {item.name: item.value for item in config.bools + config.ints + config.strs + config.doubles}
        try:
            self.check_names(wanted)
        except InputError as error:
            self.refuse(error)
            wanted = {}
        answer = encode_config(self.update_configuration(wanted))
        if self._request.refusal is not None and \
                sender(request, 'dynparam does not print why it changes nothing.').startswith(DYNPARAM):
            raise rospy.ServiceException(self._request.refusal)
        return answer

    def refuse(self, error):
        """Say that a request is refused."""
        self._request.refusal = '%s Nothing is changed.' % error
        rospy.logerr('%s', self._request.refusal)

    def _clamp(self, config):
        """Leave a number beyond its bounds as it is: it is refused, not clipped without a word."""
