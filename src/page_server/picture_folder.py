"""The pictures in the package's folder images/."""
import asyncio
import os
from concurrent.futures import ThreadPoolExecutor

from aruco_ar.base.files import package_folder
from aruco_node.health.faults import fault_barrier

FOLDER = 'images'


def list_names():
    """The sorted names of the files in images/ that can be chosen."""
    folder = os.path.join(package_folder(), FOLDER)
    try:
        return sorted(entry.name for entry in os.scandir(folder)
                      if entry.is_file() and entry.name.isprintable() and not entry.name.startswith('.')
                      and os.path.dirname(os.path.realpath(entry.path)) == os.path.realpath(folder))
    except OSError:  # the rest of the page still works
        return []


class PictureFolder:
    """Keeps the list of pictures. ``names``: those that were there when the folder was listed last.

    Another thread lists the folder, since the server must not wait for a file system that hangs.
    """

    def __init__(self, on_change):
        """``on_change`` is called, from any thread, when the names have changed."""
        self.names = list_names()
        self._on_change = on_change
        self._lister, self._listing = ThreadPoolExecutor(1, 'list of pictures'), None

    def refresh(self):
        """Begin to list the folder, unless that is in progress."""
        if self._listing is None or self._listing.done():
            self._listing = self._lister.submit(self._list)

    async def has(self, name):
        """Whether there is a picture of that name. It may be newer than the list."""
        if name not in self.names:
            await asyncio.get_event_loop().run_in_executor(self._lister, self._list)
        return name in self.names

    @fault_barrier
    def _list(self):
        names = list_names()
        if names != self.names:
            self.names = names
            self._on_change()
