"""The page of aruco-ar: the same as that of the nodes, with a camera of this desk, or a phone."""
from __future__ import annotations

import asyncio
import logging
import os
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime
from typing import Any, Callable

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.settings.declaration import parameters_of
from aruco_ar.walls.remembered import WALL_SUFFIX
from page_server.choices import Choices
from page_server.server import Images, Site, address_of_page, listen
from page_server.shared import Shared, SharedImage
from page_server.shelf import in_thread
from page_server.tiles import TILES

from .options import with_options
from .phone import Phone
from .qr import can_show, qr_code
from .studio import EXERCISES, PAINTER, Deliver, Studio

FOR_PHONES = '''Open %s on the phone, and touch "Film with this device".
The page has a certificate that this machine has just made, so the phone says that it does not know it: go on
anyway. Whoever is in the same network can open the page, too. It is served until Ctrl-C.'''
HERE, NETWORK = '127.0.0.1', '0.0.0.0'  # where the page is served: to this machine only, or to its network

MakeStudio = Callable[[Deliver, Callable[[], None]], Studio]


class _Image(SharedImage):
    """A frame of the Studio, as it comes."""

    def __init__(self, name: str, encoder: ThreadPoolExecutor, on_users_changed: Callable[[], None]) -> None:
        super().__init__(name, encoder)
        self._changed = on_users_changed

    def on_users_changed(self) -> None:
        self._changed()

    def frame_of(self, item: Image) -> Image:
        return item


class _Tags(Shared):
    """The ids of tags in a frame of the Studio."""

    def __init__(self, name: str, on_users_changed: Callable[[], None]) -> None:
        super().__init__(name)
        self._changed = on_users_changed

    def on_users_changed(self) -> None:
        self._changed()


class StudioImages(Images):
    """The images of a Studio, under the names that topics have in ROS."""

    def __init__(self, on_wanted: Callable[[dict[str, bool]], None], loop: asyncio.AbstractEventLoop) -> None:
        """``on_wanted`` is called with {exercise: whether somebody looks at it} when that changes."""
        self._on_wanted, self._loop = on_wanted, loop
        encoder = ThreadPoolExecutor(2, 'encoder')
        shown = [tile for tile in TILES if tile.number]
        self._images = {name: _Image(name, encoder, self._tell_wanted)
                        for name in ['/' + tile.topic for tile in shown]}
        self._tags = {name: _Tags(name, self._tell_wanted) for name in ['/' + tile.tags for tile in shown]}
        self._newest: dict[str, tuple[Any, int]] = {}  # {name: (item, ns)} that the loop has not taken yet
        self._lock = threading.Lock()

    async def images(self) -> list[str]:
        return sorted(self._images)

    async def image(self, name: str, exact: bool = False) -> SharedImage:
        full = '/' + name.lstrip('/')
        if full not in self._images:
            raise LookupError('There is no image "%s", but there are %s.' % (name, ', '.join(self._images)))
        return self._images[full]

    def tags(self, name: str) -> Shared:
        return self._tags[name]

    def deliver(self, name: str, item: Any, stamp: float) -> None:
        """Show an item of the Studio: see there."""
        with self._lock:  # older ones are dropped, if the loop is late
            is_first = not self._newest
            self._newest['/' + name] = item, round(stamp * 1e9)
        if is_first:
            self._loop.call_soon_threadsafe(self._store_all)

    def _store_all(self) -> None:
        with self._lock:
            newest, self._newest = self._newest, {}
        for name, (item, stamp_ns) in newest.items():
            shared: Shared = self._images.get(name) or self._tags[name]
            if shared.users:
                shared.store(item, stamp_ns)

    def _tell_wanted(self) -> None:
        self._on_wanted({name: self._images['/%s/image' % name].users + self._tags['/%s/tags' % name].users > 0
                         for name in EXERCISES})


class _Parameters:
    """The settings of a Studio, as the parameters of a node."""

    name = 'aruco-ar'

    def __init__(self, studio: Studio) -> None:
        self._studio, self._worker = studio, ThreadPoolExecutor(1, 'parameters')

    @property
    def values(self) -> dict[str, Any]:
        settings = self._studio.settings
        return {name: parameter.kind.to_plain(getattr(settings, name))
                for name, parameter in parameters_of(settings).items()}

    async def set(self, **values: Any) -> None:
        await in_thread(self._worker, self._studio.change, values)


class _Choices(Choices):
    """The choices of a Studio. It writes walls into the current folder."""

    def __init__(self, studio: Studio, on_change: Callable[[], None]) -> None:
        super().__init__({PAINTER: _Parameters(studio)}, on_change)
        self._studio = studio

    def take(self, picture: Image) -> None:
        self._studio.drop(picture)

    @property
    def drop_value(self) -> str:
        return self._studio.drop_value

    def saved_wall(self) -> str:
        path = os.path.abspath('wall_%s%s' % (datetime.now().strftime('%Y-%m-%d_%H-%M-%S'), WALL_SUFFIX))
        self._studio.save_wall(path)
        return path


class DeskSite(Site):
    """The Site of a Studio."""

    def __init__(self, make_studio: MakeStudio, loop: asyncio.AbstractEventLoop,
                 phone: Phone | None = None) -> None:
        tiles = [tile._replace(topic='/' + tile.topic, tags='/' + tile.tags) for tile in TILES if tile.number]
        super().__init__(tiles, loop)
        self.phone = phone
        self.topics = images = StudioImages(self._on_wanted, loop)
        self._studio = make_studio(images.deliver, self.on_change)
        self._studio.start()
        self.choices = _Choices(self._studio, self.on_change)

    def now(self) -> float:
        return time.time()

    def advice_of(self, node: str) -> tuple[str, bool]:
        sentence, is_trouble = self._studio.advice
        return (sentence, is_trouble) if is_trouble or node == '/' + PAINTER else ('', False)

    def end(self) -> None:
        """Film no longer."""
        if self.phone is not None:
            self.phone.end()
        self._studio.end()

    def _on_wanted(self, wanted: dict[str, bool]) -> None:
        self._studio.wanted = wanted


def serve(make_studio: MakeStudio, port: int, phone: Phone | None = None) -> None:
    """Serve the page of a Studio until Ctrl-C. ``make_studio``: makes it of a ``deliver`` and an ``on_change``.

    With a Phone, the page is served to the whole network, over HTTPS. Raises InputError if the page cannot be
    served, or if the settings cannot be used.
    """
    # Phones first refuse the certificate, which is no news for this terminal.
    logging.getLogger('tornado.general').setLevel(logging.ERROR)
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    address, tls = HERE, None
    if phone is not None:
        from .certificate import made_on_the_spot, own_address
        address = own_address()
        tls = made_on_the_spot(address)
    site = DeskSite(make_studio, loop, phone)
    try:
        server = listen(site, HERE if phone is None else NETWORK, port, tls)
    except InputError as error:
        site.end()
        raise InputError(with_options(str(error))) from None
    place = address_of_page(address, port, tls)
    if phone is not None and can_show(sys.stdout):
        print(qr_code(place))
    print(('The page is at %s until Ctrl-C.' if phone is None else FOR_PHONES) % place, flush=True)
    with suppress(KeyboardInterrupt):
        loop.run_forever()
    server.stop()
    site.end()
