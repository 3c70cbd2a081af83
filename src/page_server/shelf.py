"""The pictures that can be chosen: the files in images/, and the one that was dropped onto the page last."""
from __future__ import annotations

import asyncio
import gc
import logging
import os
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any, Callable

from aruco_ar.base.arrays import Image
from aruco_ar.base.errors import InputError
from aruco_ar.base.files import package_folder
from aruco_ar.painting.jpeg_file import jpeg_from_frame
from aruco_ar.painting.picture_file import decode_picture, open_header, resize
from aruco_ar.painting.sources import open_source
from PIL.Image import DecompressionBombError

FOLDER = 'images'
FORMATS = 'JPEG', 'PNG', 'WEBP', 'BMP'
MAX_BYTES = 16 * 1024 * 1024
MAX_PIXELS = 32 * 1000 * 1000
THUMBNAIL_PX = 160
ANSWER_S = 5.0
_log = logging.getLogger('tornado.application')  # as tornado logs errors of handlers


class Shelf:
    """The pictures, by their names. All browsers share it."""

    def __init__(self, on_change: Callable[[], None]) -> None:
        """``on_change`` is called, from any thread, when there are other files."""
        self._on_change = on_change
        self._worker = ThreadPoolExecutor(1, 'pictures')  # decodes and shrinks what is in memory
        # These wait for the file system, which may hang. The event loop never does.
        self._folder, self._reader = ThreadPoolExecutor(1, 'folder'), ThreadPoolExecutor(1, 'reader')
        self._package = package_folder()
        self._files: list[str] = []
        self._listing: Future[None] | None = None
        self._thumbnails: dict[str, asyncio.Future[bytes]] = {}
        self._drops = 0  # number of pictures that were dropped; only the last one can be chosen again

    def names(self) -> list[str]:
        """The sorted names of the files, and the name of the picture that was dropped last.

        The files are those of a moment ago; they are looked for again, and ``on_change`` is called if there are
        others.
        """
        self._look_for_files()
        return self._files + [self.drop_name] * (self._drops > 0)

    @property
    def drop_name(self) -> str:
        """The name of the picture that was dropped last."""
        return 'dropped %d' % self._drops

    def is_dropped(self, name: str) -> bool:
        """Whether the picture of that name is the one that was dropped last."""
        return self._drops > 0 and name == self.drop_name

    async def check(self, name: str) -> None:
        """Raise InputError unless there is a picture of that name."""
        if self.is_dropped(name):
            return
        listing = asyncio.shield(asyncio.wrap_future(self._look_for_files()))
        try:
            await asyncio.wait_for(listing, ANSWER_S)
        except asyncio.TimeoutError:
            raise InputError('The folder %s/ cannot be read: its file system does not answer.'
                             % FOLDER) from None
        if name not in self._files:
            raise InputError('There is no picture "%s" in %s/.' % (name, FOLDER))

    async def drop(self, parts: list[bytes], take: Callable[[Image], Any]) -> Any:
        """Have a new picture be the one that was dropped last. Returns what ``take`` returns of its pixels.

        ``parts``: a list with the bytes of its file, which is emptied. Raises InputError if they are not a
        usable picture.
        """
        def decoded_and_taken() -> tuple[Image, Any]:
            picture = _decode(parts)
            return picture, take(picture)
        picture, taken = await in_thread(self._worker, decoded_and_taken)
        self._thumbnails.pop(self.drop_name, None)
        self._drops += 1
        self._thumbnails[self.drop_name] = in_thread(self._worker, _shrink, picture)
        return taken

    async def thumbnail(self, name: str) -> bytes:
        """The picture of that name as a small JPEG. Raises InputError if there is none."""
        await self.check(name)
        if name not in self._thumbnails:
            path = os.path.join(self._package, FOLDER, name)
            self._thumbnails[name] = in_thread(self._reader, lambda: _shrink(open_source(path).at(0)))
        try:
            return await asyncio.shield(self._thumbnails[name])  # shield: other requests may wait for it, too
        except Exception:
            self._thumbnails.pop(name, None)  # the file may be repaired later
            raise

    def name_of(self, path: str) -> str:
        """The name of the picture with this path, in full or within the package; '' if it is none of these."""
        folder, name = os.path.split(os.path.join(self._package, path))
        return name if folder == os.path.join(self._package, FOLDER) else ''

    def _look_for_files(self) -> Future[None]:
        """Read the names of the files again, in a thread. Returns its Future."""
        if self._listing is None or self._listing.done():
            self._listing = self._folder.submit(self._read_folder)
        return self._listing

    def _read_folder(self) -> None:
        try:
            files = files_in(os.path.join(self._package, FOLDER))
            if files != self._files:
                self._files = files
                self._on_change()
        except Exception:  # nobody may ask for the result
            _log.exception('The folder %s/ cannot be read', FOLDER)


def files_in(folder: str) -> list[str]:
    """The sorted names of the files of a folder that can be chosen: no hidden ones, and no links out of it."""
    try:
        return sorted(entry.name for entry in os.scandir(folder)
                      if entry.is_file() and entry.name.isprintable() and not entry.name.startswith('.')
                      and os.path.dirname(os.path.realpath(entry.path)) == os.path.realpath(folder))
    except OSError:  # the rest of the page still works
        return []


def in_thread(worker: Executor, work: Callable[..., Any], *arguments: Any) -> asyncio.Future[Any]:
    """A Future of what a function returns that an executor runs."""
    return asyncio.get_event_loop().run_in_executor(worker, work, *arguments)


def _decode(parts: list[bytes]) -> Image:
    gc.collect()  # the traceback of an earlier refusal may still hold that picture
    data = b''.join(parts)
    parts.clear()
    try:  # only the header, before memory is allocated for the pixels
        with open_header(data, FORMATS) as image:
            pixels = image.width * image.height
    except DecompressionBombError:
        pixels = MAX_PIXELS + 1
    except Exception:  # Pillow raises exceptions of many kinds
        raise InputError('This file is not a picture. Drop a JPEG or PNG. Put videos and GIFs into %s/.'
                         % FOLDER) from None
    if pixels > MAX_PIXELS:
        raise InputError('The picture is too large. Drop one of at most %d million pixels.'
                         % (MAX_PIXELS // 10**6))
    return decode_picture(data, 'dropped')


def _shrink(picture: Image) -> bytes:
    return jpeg_from_frame(resize(picture[..., :3], min(1, THUMBNAIL_PX / max(picture.shape[:2]))))
