"""Parameters of nodes: the fields of a class of settings (see aruco_ar.settings.declaration).

All that ROS has of them is made from that. reconfigure makes what
dynamic_reconfigure offers, and manual makes what ``--help`` prints.
script/remake/launch_args makes the arguments of the launch files. The checks at a
node's start and the tables of the documentation also come from it.
"""
from aruco_ar.settings.declaration import checked, parameters_of, parsed

AUTO = 'auto'


def switch(default, what):
    """A dataclass's field for a parameter that is True, False, or AUTO, with which the node decides."""
    return parsed(default, 'true, false or auto', what, _true_false_or_auto, lambda value: value, live=False)


def _true_false_or_auto(value):
    if value != AUTO and not isinstance(value, bool):
        raise ValueError
    return value


def read(kind_of_settings, get):
    """An instance of a class of settings; ``get(name, default)`` looks up what a parameter server has.

    Raises InputError with the name of the parameter, its value, and which values it takes.
    """
    defaults = ros_values(kind_of_settings())
    return kind_of_settings(**{name: checked('~' + name, parameter, get(name, defaults[name]))
                               for name, parameter in parameters_of(kind_of_settings).items()})


def ros_values(settings):
    """{name: value} of an instance of settings, as a parameter server keeps them."""
    return {name: parameter.kind.to_plain(getattr(settings, name))
            for name, parameter in parameters_of(settings).items()}
