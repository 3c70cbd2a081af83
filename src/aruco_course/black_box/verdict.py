"""What the check of a node found, and the command that checks one."""
from __future__ import annotations

import json
import os
import sys
from dataclasses import asdict, dataclass, field

NAME = 'check_node.py'


@dataclass
class NodeVerdict:
    """Whether a node is right.

    ``fault``: the first thing that is wrong, with its ``place``, or nothing. ``remarks``: what is not asked
    for, but would be better. ``picture``: the path of the verdict's picture, or nothing. ``printed``: what the
    node printed last. ``seconds``: how long the check took.
    """

    exercise: str
    node: str
    passed: bool
    fault: str = ''
    place: str = ''
    remarks: list[str] = field(default_factory=list)
    picture: str = ''
    printed: str = ''
    seconds: float = 0.0

    def line(self) -> str:
        """As a line of JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def of_output(cls, output: str) -> NodeVerdict | None:
        """The verdict that check_node.py printed as its last line, or None."""
        for line in reversed(output.splitlines()):
            if line.startswith('{'):
                try:
                    return cls(**json.loads(line))
                except (ValueError, TypeError):
                    continue
        return None


def command_for_node(exercise: str, node: str, image: str = '', mask: str = '', picture: str = '',
                     camera: str = '', bag: str = '', verdict: str = '') -> list[str]:
    """The command that checks a node in a ROS of its own, and prints a NodeVerdict as JSON in its last line.

    ``exercise``: such as "5.4". ``node``: package/program or the path of a program. ``verdict``: the path of a
    PNG for the verdict's picture. For the others see ``check_node.py --help``; nothing stands for their
    defaults. The command returns 0 for a pass, 1 for a fault, 2 if there could be no verdict: then stderr has a
    sentence.
    """
    options = dict(image=image, mask=mask, picture=picture, camera=camera, bag=bag, verdict=verdict)
    return [sys.executable, _program(), '--json', *['--%s=%s' % item for item in options.items() if item[1]],
            exercise, node]


def _program() -> str:
    """The path of check_node.py: in nodes/ of the source folder, or in lib/unit5 of an install space."""
    source = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..', '..'))
    path = os.path.join(source, 'nodes', NAME)
    if os.path.exists(path):
        return path
    import rospkg  # without ROS no node can run
    share = rospkg.RosPack().get_path('unit5')
    paths = [os.path.join(share, 'nodes', NAME), os.path.join(share, '..', '..', 'lib', 'unit5', NAME)]
    return os.path.abspath(next((path for path in paths if os.path.exists(path)), paths[-1]))
