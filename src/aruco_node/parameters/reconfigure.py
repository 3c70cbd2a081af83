"""Changing parameters while a node runs: dynamic_reconfigure, without .cfg files.

A .cfg file would repeat, for each node, what its settings say already (see
parameters). Here what dynamic_reconfigure offers is made from the settings.
"""
from types import SimpleNamespace

import rospy
from aruco_ar.base.errors import InputError, shorten
from aruco_ar.settings.declaration import MAX_QUOTED, Choice, Number, parameters_of

from aruco_node.health.faults import note_fault
from aruco_node.ros_internals.master import ask
from aruco_node.ros_internals.reconfigure_server import CheckedServer
from aruco_node.ros_internals.registration import before_registering

from .parameters import read, ros_values


class Reconfigurer(CheckedServer):
    """Offers those parameters of some settings which can be changed while the node runs.

    ``settings``: an instance of a class of settings. ``on_change`` is called,
    from any thread, with the changed settings. If it raises InputError, or if a
    value is not allowed, the node logs the reason and nothing is changed.
    """

    def __init__(self, settings, on_change):
        self._settings, self._on_change = settings, on_change
        super().__init__(_description(type(settings)), self._reconfigure)
        before_registering(self._put_back)

    def check_names(self, names):
        live = self.live_values()
        for name in names:
            if name not in live:
                raise InputError('The parameter ~%s cannot be changed while the node runs; those that can be '
                                 'changed are ~%s.' % (shorten(name, MAX_QUOTED), ', ~'.join(live)))

    def _put_back(self):
        """Give all parameters to a master that has lost them, so that a restarted node finds them there."""
        for name, value in ros_values(self._settings).items():
            if not ask('hasParam', rospy.resolve_name('~' + name))[1]:
                ask('setParam', rospy.resolve_name('~' + name), value)

    def live_values(self):
        return self._live(self._settings)

    def _live(self, settings):
        """{name: value} of the parameters that can be changed while the node runs."""
        values = ros_values(settings)
        return {name: values[name] for name, parameter in parameters_of(settings).items() if parameter.live}

    def _reconfigure(self, config, level):
        """Change the settings to ``config``, {name: value}, if that is allowed; returns what they are then."""
        kept = ros_values(self._settings)
        try:
            settings = read(type(self._settings), lambda name, default: config.get(name, kept[name]))
            if settings != self._settings:
                self._on_change(settings)
        except InputError as error:
            self.refuse(error)
        except Exception as error:  # a fault of ours: one request is refused, and the node goes on
            note_fault(error)
            self.refuse('The parameters cannot be changed, because this node has a fault.')
        else:
            self._settings = settings
        config.update(self._live(self._settings))
        return config


def _description(kind_of_settings):
    """As much of what generate_dynamic_reconfigure_options makes of a .cfg file as the base class needs."""
    defaults = ros_values(kind_of_settings())
    parameters = [_parameter_description(name, parameter, defaults[name])
                  for name, parameter in parameters_of(kind_of_settings).items() if parameter.live]
    described = {key: {each['name']: each[key] for each in parameters} for key in ('min', 'max', 'level')}
    return SimpleNamespace(
        defaults={each['name']: each['default'] for each in parameters}, **described,
        config_description={'name': 'Default', 'type': '', 'state': True, 'id': 0, 'parent': 0,
                            'parameters': parameters, 'groups': []})


def _parameter_description(name, parameter, default):
    is_number = isinstance(parameter.kind, Number)
    choices = [{'name': value, 'value': value, 'type': 'str', 'description': value}
               for value in parameter.kind.listed] if isinstance(parameter.kind, Choice) else []
    return {'name': name, 'type': 'double' if is_number else 'str', 'default': default, 'level': 0,
            'description': parameter.what,
            # A bound must be a float: an int would make the parameter one of integers.
            'min': float(parameter.kind.low) if is_number else '',
            'max': float(parameter.kind.high) if is_number else '',
            'edit_method': repr({'enum': choices, 'enum_description': parameter.what}) if choices else ''}
