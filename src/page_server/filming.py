"""The websocket of a device that films for the page: it sends JPEGs, and is told when each has arrived."""
from __future__ import annotations

from typing import Any

from tornado.websocket import WebSocketHandler

from .handlers import BaseHandler

MAX_BYTES = 4 * 1024 * 1024  # of a frame
ARRIVED = 'arrived'
OTHER = 4000, 'Another device films now.'  # codes from 4000 on are for programs


class Film(BaseHandler, WebSocketHandler):
    """The websocket of a device that films. The last one that has begun is the camera."""

    def initialize(self, site: Any) -> None:
        self.site = site

    def prepare(self) -> None:
        super().prepare()
        if not self._finished and self.site.phone is None:
            self.refuse(404, 'This server has a camera of its own.')

    def check_origin(self, origin: str) -> bool:
        return True  # prepare has refused other sites

    @property
    def max_message_size(self) -> int:
        return MAX_BYTES

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        if self.site.filming is not None:
            self.site.filming.close(*OTHER)
        self.site.filming = self

    def on_close(self) -> None:
        if self.site.filming is self:
            self.site.filming = None

    async def on_message(self, message: str | bytes) -> None:
        if self.site.filming is self and isinstance(message, bytes):
            self.site.phone.take(message)
            await self.write_message(ARRIVED)
