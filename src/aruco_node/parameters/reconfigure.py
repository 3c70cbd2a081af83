"""Changing parameters while a node runs: dynamic_reconfigure, from a class of settings.

The .cfg files that dynamic_reconfigure usually takes would say once more what
the settings say (see parameters), once for each node.
"""
from types import SimpleNamespace

import rospy
from aruco_ar.base.errors import InputError, shorten
from dynamic_reconfigure.encoding import encode_config
from dynamic_reconfigure.server import Server

from aruco_node.health.faults import note_fault
from aruco_node.ros_internals.master import ask
from aruco_node.ros_internals.registration import before_registering

from .parameters import MAX_SHOWN, Choice, Number, abouts, plain, read


class Reconfigurer(Server):
    """Serves the parameters of settings; what is not allowed is refused with a sentence.

    ``on_change`` is called, from any thread, with other settings; it may raise
    InputError, then all stays as it was.
    """

    def __init__(self, settings, on_change):
        self._settings, self._on_change = settings, on_change
        super().__init__(_describe(type(settings)), self._reconfigure)
        before_registering(self._put_back)

    def _copy_from_parameter_server(self):
        """Begin with what has been read and checked, in place of what the parameter server holds."""
        self.config.update(self._live(self._settings))

    def _set_callback(self, request):
        """Answer a wish with all parameters as they are then.

        The names of the parameters alone count: of the groups, which nobody has
        here, the server would take any, and fail for those that are none.
        """
        config = request.config
        wishes = {item.name: item.value for item in config.bools + config.ints + config.strs + config.doubles}
        try:
            self._check_names(wishes)
        except InputError as error:
            rospy.logerr('%s Nothing is changed.', error)
            wishes = {}
        return encode_config(self.update_configuration(wishes))

    def _check_names(self, names):
        live = self._live(self._settings)
        for name in names:
            if name not in live:
                raise InputError('The parameter ~%s cannot be changed while the node runs; those that can be '
                                 'are ~%s.' % (shorten(name, MAX_SHOWN), ', ~'.join(live)))

    def _copy_to_parameter_server(self):
        try:
            for name, value in self._live(self._settings).items():
                ask('setParam', rospy.resolve_name('~' + name), value)
        except InputError as error:
            rospy.logwarn('%s. What has been changed counts all the same.', error)

    def _put_back(self):
        """Tell a master that has lost the parameters of them: who starts the node again wants the same."""
        for name, value in plain(self._settings).items():
            if not ask('hasParam', rospy.resolve_name('~' + name))[1]:
                ask('setParam', rospy.resolve_name('~' + name), value)

    def _clamp(self, config):
        """Leave a number that is too large as it is: it is refused, not cut without a word."""

    def _live(self, settings):
        values = plain(settings)
        return {name: values[name] for name, about in abouts(settings).items() if about.live}

    def _reconfigure(self, config, level):
        """What the server calls with what somebody wishes; returns what it becomes."""
        kept = plain(self._settings)
        try:
            settings = read(type(self._settings), lambda name, default: config.get(name, kept[name]))
            if settings != self._settings:
                self._on_change(settings)
        except InputError as error:
            rospy.logerr('%s Nothing is changed.', error)
        except Exception as error:  # a fault of ours: one wish is refused, and the node goes on
            note_fault(error)
            rospy.logerr('The parameters cannot be changed, by a fault of this node. Nothing is changed.')
        else:
            self._settings = settings
        config.update(self._live(self._settings))
        return config


def _describe(kind_of_settings):
    """What generate_dynamic_reconfigure_options makes of a .cfg file, as far as the server needs it."""
    parameters = [_parameter(name, about, plain(kind_of_settings())[name])
                  for name, about in abouts(kind_of_settings).items() if about.live]
    described = {key: {each['name']: each[key] for each in parameters} for key in ('min', 'max', 'level')}
    return SimpleNamespace(
        defaults={each['name']: each['default'] for each in parameters}, **described,
        config_description={'name': 'Default', 'type': '', 'state': True, 'id': 0, 'parent': 0,
                            'parameters': parameters, 'groups': []})


def _parameter(name, about, default):
    is_number = isinstance(about.kind, Number)
    choices = [{'name': value, 'value': value, 'type': 'str', 'description': value}
               for value in about.kind.shown] if isinstance(about.kind, Choice) else []
    return {'name': name, 'type': 'double' if is_number else 'str', 'default': default, 'level': 0,
            'description': about.what,
            # As floats: a bound that is an int would be said to be one of an int parameter.
            'min': float(about.kind.low) if is_number else '',
            'max': float(about.kind.high) if is_number else '',
            'edit_method': repr({'enum': choices, 'enum_description': about.what}) if choices else ''}
