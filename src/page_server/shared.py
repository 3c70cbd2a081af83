"""What arrives again and again, and is kept for browsers: frames, and the tags beside them."""
from __future__ import annotations

import asyncio
import time
from collections import deque
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any, Callable, Iterator

import cv2
import numpy as np
from aruco_ar.base.arrays import Image
from aruco_ar.painting.jpeg_file import JPEG_QUALITY, jpeg_from_frame

RATE_S = 2.0      # frame rates are measured over this time
MAX_SIDE_PX = 4096


class Shared:
    """The newest item of a stream, for several coroutines.

    ``item``: None until one has arrived. ``number``: how many have arrived. ``stamp_ns``: when the item was
    made, in ns by the camera's clock. A subclass has the items come only while ``users`` is not 0.
    """

    def __init__(self, name: str) -> None:
        self.name, self.users, self.number, self.stamp_ns = name, 0, 0, 0
        self.item: Any = None
        self._loop = asyncio.get_event_loop()
        self._arrival: asyncio.Future[None] = self._loop.create_future()
        self._times: deque[float] = deque(maxlen=256)

    def on_users_changed(self) -> None:
        """Called in the event loop when ``users`` has changed."""
        raise NotImplementedError

    @contextmanager
    def subscribed(self) -> Iterator[None]:
        """A context manager: the items come within the block."""
        self.users += 1
        self.on_users_changed()
        try:
            yield
        finally:
            self.users -= 1
            if not self.users:
                self.item = None  # it will be outdated when the next user comes
            self.on_users_changed()

    def store(self, item: Any, stamp_ns: int) -> None:
        """A new item has arrived. Call it in the event loop."""
        self.item, self.number, self.stamp_ns = item, self.number + 1, stamp_ns
        self._times.append(time.monotonic())
        self._arrival.set_result(None)
        self._arrival = self._loop.create_future()

    async def newer(self, number: int, seconds: float) -> bool:
        """Wait for an item newer than that with this ``number``. Returns whether one arrived in time."""
        if self.number == number:
            await asyncio.wait([self._arrival], timeout=seconds)
        return self.number != number

    @property
    def age(self) -> float:
        """Seconds since the newest item arrived; inf if there is none."""
        return time.monotonic() - self._times[-1] if self.item is not None and self._times else float('inf')

    @property
    def rate(self) -> float:
        """Items per second during the last RATE_S."""
        now = time.monotonic()
        while len(self._times) > 1 and now - self._times[0] > RATE_S:
            self._times.popleft()
        span = self._times[-1] - self._times[0] if self._times else 0
        return (len(self._times) - 1) / span if span > 0 else 0.0


class SharedImage(Shared):
    """The newest frame of a camera or an exercise, also as JPEG."""

    def __init__(self, name: str, encoder: Executor) -> None:
        """``encoder``: an executor that encodes JPEGs."""
        super().__init__(name)
        self._encoder = encoder
        self._made: dict[Any, asyncio.Future[Any]] = {}  # {(function, options): result}, of the newest frame
        self._made_number = -1

    def frame_of(self, item: Any) -> Image:
        """The frame, (h, w, 3) BGR uint8, of an item. Called by the encoder. Raises InputError."""
        raise NotImplementedError

    def jpeg_of(self, item: Any, most_width: int | None) -> bytes | None:
        """The JPEG that an item is already, if it is not wider than ``most_width``. Called by the encoder."""
        return None

    async def jpeg(self, quality: int | None = None, width: int | None = None, height: int | None = None,
                   most_width: int | None = None) -> bytes:
        """The newest frame as the bytes of a JPEG.

        ``quality``: 1 to 100. ``width``, ``height``: pixels. None leaves it as it is. ``most_width``: a wider
        frame is shrunk to this width, pixels. Raises InputError if the frame cannot be used.
        """
        jpeg: bytes = await self._shared(self._encode, quality, width, height, most_width)
        return jpeg

    async def frame(self, most_width: int | None = None) -> Image:
        """The newest frame, (h, w, 3) BGR uint8; see ``jpeg``. Others may use it, too, so do not change it."""
        return np.asarray(await self._shared(self._sized, None, None, most_width))

    async def in_encoder(self, work: Callable[..., Any], *arguments: Any) -> Any:
        """What a function returns, called where JPEGs are encoded."""
        return await self._loop.run_in_executor(self._encoder, work, *arguments)

    async def _shared(self, work: Callable[..., Any], *options: Any) -> Any:
        """What a function of the newest item returns. Requests with the same options share the work."""
        if self._made_number != self.number:
            self._made, self._made_number = {}, self.number
        if (work, options) not in self._made:
            self._made[work, options] = self._loop.run_in_executor(self._encoder, work, self.item, *options)
        return await asyncio.shield(self._made[work, options])

    def _encode(self, item: Any, quality: int | None, width: int | None, height: int | None,
                most_width: int | None) -> bytes:
        made = None if quality or width or height else self.jpeg_of(item, most_width)
        if made is not None:
            return made
        return jpeg_from_frame(self._sized(item, width, height, most_width), quality or JPEG_QUALITY)

    def _sized(self, item: Any, width: int | None, height: int | None, most_width: int | None) -> Image:
        frame = self.frame_of(item)
        if most_width and frame.shape[1] > most_width:
            width = most_width
        if width or height:
            size = (width or round(frame.shape[1] * (height or 1) / frame.shape[0]),
                    height or round(frame.shape[0] * (width or 1) / frame.shape[1]))
            frame = cv2.resize(frame, [min(max(side, 1), MAX_SIDE_PX) for side in size],
                               interpolation=cv2.INTER_AREA)
        return frame
