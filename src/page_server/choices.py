"""The choices on the page: which picture is painted and how, which tags count, and how the simulation looks."""
from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Iterable, Mapping, Protocol

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.settings.declaration import checked, parameters_of
from aruco_ar.settings.settings import FOREGROUNDS, GRAINS, LEARN, LIGHTS, TAGS, PictureSettings
from aruco_ar.simulation.figures import NOBODY

from .shelf import ANSWER_S, FOLDER, Shelf, in_thread

EXERCISES = 'exercise5_2', 'exercise5_3', 'exercise5_4', 'exercise5_5', 'exercise5_6'
PAINTER, SIMULATION = EXERCISES[-1:], ('wall_camera',)
# The nodes that have each parameter. Sliders set numbers, and fields set texts.
SLIDERS = {'opacity': PAINTER, 'noise': SIMULATION, 'falloff': SIMULATION}
FIELDS = {'fit': PAINTER, 'dictionary': EXERCISES, 'ids': EXERCISES}
# The nodes that have each switch's parameter, and its values for off and on.
SWITCHES = {'foreground': (PAINTER, FOREGROUNDS), 'light': (PAINTER, LIGHTS), 'grain': (PAINTER, GRAINS),
            'tags': (PAINTER, TAGS), 'visitor': (SIMULATION, (NOBODY, 'person'))}
# The switch that has a wall remembered: the nodes that then know it. Their parameter names its file.
WALL, KNOWING = 'wall', EXERCISES[:-3:-1]


class Parameters(Protocol):
    """The parameters of one node, or of what takes its place.

    ``name``: what sentences call the node.
    """

    name: str

    @property
    def values(self) -> Mapping[str, Any]:
        """{parameter: value}; empty while the node is not running."""

    async def set(self, **values: Any) -> None:
        """Set parameters, texts or numbers. Raises InputError if they are refused."""


class Choices:
    """What can be chosen, and what is chosen. All browsers share it.

    A subclass says what happens to a picture that is dropped, and how a wall is saved.
    """

    def __init__(self, nodes: Mapping[str, Parameters], on_change: Callable[[], None]) -> None:
        """``nodes``: {name: Parameters}, the painter among them.

        ``on_change`` is called, from any thread, when a choice has changed, on the page or elsewhere.
        """
        self._nodes, self._shelf = nodes, Shelf(on_change)
        self._saver = ThreadPoolExecutor(1, 'saver')  # waits for a node
        self._choice = 0  # number of the last choice of a picture

    def take(self, picture: Image) -> None:
        """Take a picture that was dropped, to be painted as ``drop_value``. Called in a thread."""
        raise NotImplementedError

    @property
    def drop_value(self) -> str:
        """The value of the parameter ``picture`` that has the dropped picture painted."""
        raise NotImplementedError

    def saved_wall(self) -> str:
        """Have the wall saved. Returns the path of its file. Called in a thread. Raises InputError."""
        raise NotImplementedError

    def state(self) -> dict[str, Any]:
        """The part of the page's state with what can be chosen, and what is chosen."""
        values = {name: node.values for name, node in self._nodes.items()}

        def value(parameter: str, nodes: Iterable[str]) -> Any:
            """The parameter's value in the first of these nodes that is running, or None."""
            return next((values[name][parameter] for name in nodes if parameter in values.get(name, ())), None)
        picture = value('picture', PAINTER)
        switches = {name: (value(name, nodes), on) for name, (nodes, (_, on)) in SWITCHES.items()}
        wall = value(WALL, KNOWING)
        return {'pictures': self._shelf.names(), 'picture': None if picture is None else self._name_of(picture),
                'sliders': _known({name: value(name, nodes) for name, nodes in SLIDERS.items()}),
                'fields': _known({name: value(name, nodes) for name, nodes in FIELDS.items()}),
                'switches': {**{name: now == on for name, (now, on) in switches.items() if now is not None},
                             **({} if wall is None else {WALL: wall != LEARN})}}

    async def choose(self, name: str) -> None:
        """Have the picture of that name painted, unless another one is chosen meanwhile.

        Raises InputError if there is none.
        """
        self._choice += 1
        choice = self._choice
        await self._shelf.check(name)
        if choice != self._choice:
            return
        await self._set(PAINTER, picture=self.drop_value if self._shelf.is_dropped(name) else
                        '%s/%s' % (FOLDER, name))

    async def drop(self, parts: list[bytes]) -> None:
        """Have a new picture painted. ``parts``: a list with the bytes of its file, which is emptied.

        Raises InputError if they are not a usable picture.
        """
        await self._shelf.drop(parts, self.take)
        self._choice += 1
        await self._set(PAINTER, picture=self.drop_value)

    async def thumbnail(self, name: str) -> bytes:
        """The picture of that name as a small JPEG. Raises InputError if there is none."""
        return await self._shelf.thumbnail(name)

    async def slide(self, name: Any, value: Any) -> None:
        """Set one of SLIDERS. Other names and values are ignored. Raises InputError if no node has it."""
        if isinstance(name, str) and name in SLIDERS and isinstance(value, (int, float)) and abs(value) < 1e6:
            await self._set(SLIDERS[name], **{name: value})

    async def write(self, name: Any, value: Any) -> None:
        """Set one of FIELDS, in all nodes that have it.

        Other names are ignored. Raises InputError if the value is not allowed, or if no node has it.
        """
        if isinstance(name, str) and name in FIELDS and isinstance(value, str):
            parameter = parameters_of(PictureSettings)[name]
            taken = checked('~' + name, parameter, value)  # refused here, with the reason
            await self._set(FIELDS[name], **{name: parameter.kind.to_plain(taken)})

    async def switch(self, name: Any, on: Any) -> None:
        """Turn a switch on or off. Other names are ignored.

        Raises InputError if its node is not running, or if there is no wall to remember yet.
        """
        if name == WALL and isinstance(on, bool):
            wall = await self._saved_wall() if on else LEARN
            await self._set(PAINTER, wall=wall)
            others = [self._nodes[name] for name in KNOWING if name not in PAINTER and name in self._nodes]
            await asyncio.gather(*[node.set(wall=wall) for node in others if node.values])
        elif isinstance(name, str) and name in SWITCHES and isinstance(on, bool):
            nodes, values = SWITCHES[name]
            await self._set(nodes, **{name: values[on]})

    async def _saved_wall(self) -> str:
        try:
            saved: str = await asyncio.wait_for(in_thread(self._saver, self.saved_wall), ANSWER_S)
        except asyncio.TimeoutError:
            raise not_answering(self._nodes[PAINTER[0]].name) from None
        return saved

    async def _set(self, names: Iterable[str], **values: Any) -> None:
        """Set parameters of all these nodes that are running. If none is, the first one refuses."""
        nodes = [self._nodes[name] for name in names if name in self._nodes]
        await asyncio.gather(*[node.set(**values) for node in nodes if node.values]
                             or [node.set(**values) for node in nodes[:1]])

    def _name_of(self, picture: str) -> str:
        """The page's name for the picture that exercise 5.6 paints, or '' if it cannot be chosen."""
        return self._shelf.drop_name if picture == self.drop_value else self._shelf.name_of(picture)


def not_answering(name: str) -> InputError:
    """The InputError for a node that does not answer."""
    return InputError('%s does not answer. Start it, or look at its log.' % name)


def _known(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}
