"""Sets parameters in ways that no client of ROS would: by the parameter server or dynamic_reconfigure."""
import os
import xmlrpc.client
from urllib.request import Request, urlopen

from dynamic_reconfigure.msg import (
    BoolParameter,
    Config,
    DoubleParameter,
    GroupState,
    IntParameter,
    StrParameter,
)

from hostile.parameters.values import INT32, LONG, as_xml

KINDS = {str: ('strs', StrParameter), float: ('doubles', DoubleParameter), int: ('ints', IntParameter),
         bool: ('bools', BoolParameter)}
REFUSED = ' Nothing is changed.'  # the end of each sentence that refuses a change
# Configs with groups of all kinds, which say nothing about any parameter.
GROUPS = [Config(groups=[GroupState('Default', False, *ids)]) for ids in
          ((0, 0), (1, 0), (1, 1), (-1, -1), (INT32 - 1, -INT32))]
GROUPS += [Config(groups=[GroupState('a', True, 1, 2), GroupState('b', True, 2, 1),
                          GroupState('Default', True, 0, 0)]),
           Config(groups=[GroupState('', True, 0, 0)] * 100), Config()]
# Configs with names that no live parameter has.
NAMES = [Config(strs=[StrParameter(name, 'x')]) for name in (
    '', ' ', 'groups', '~scale', 'Scale', 'scale ', 'é', 'two\nlines', '\0', '\x1b[31m', '__class__', 'copy',
    'state', '%s')]
NAMES += [Config(ints=[IntParameter('groups', 1)]), Config(bools=[BoolParameter('groups', True)]),
          Config(strs=[StrParameter('a' * LONG, 'a' * LONG)]),
          Config(strs=[StrParameter('image_transport', 'compressed'), StrParameter('areas', 'x.yaml')]),
          Config(doubles=[DoubleParameter('name %d' % number, number) for number in range(1000)])]


def config_with(name, value):
    """The Config that sets a parameter to a text, float, int or bool."""
    fields, kind = KINDS[type(value)]
    return Config(**{fields: [kind(name, value)]})


def values_of(config):
    """{name: value} of a Config."""
    return {item.name: item.value for fields, _ in KINDS.values() for item in getattr(config, fields)}


def set_parameter(name, value):
    """Set a parameter to a value that as_xml can write; returns whether the master accepted it."""
    call = xmlrpc.client.dumps(('/hostile', name, 0), 'setParam')
    call = call.replace('<value><int>0</int></value>', as_xml(value))
    answer = urlopen(Request(os.environ['ROS_MASTER_URI'], call.encode(), {'Content-Type': 'text/xml'})).read()
    try:
        return xmlrpc.client.loads(answer)[0][0][0] == 1
    except xmlrpc.client.Fault:
        return False
