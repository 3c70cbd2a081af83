"""Files that are written under another name, so that nobody sees half of one."""
from __future__ import annotations

import os
from contextlib import contextmanager, suppress
from typing import Iterator


@contextmanager
def drafted(path: str, folder: str) -> Iterator[str]:
    """A context manager with the path of a new draft in a folder. After the block, the draft becomes ``path``.

    No other process has the same draft. When a cluster loses contact with a worker, another worker starts the
    same piece, although the first one may still be writing.
    """
    draft = os.path.join(folder, os.urandom(8).hex() + os.path.splitext(path)[1])
    try:
        yield draft
        if os.path.exists(draft):
            os.replace(draft, path)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(draft)
