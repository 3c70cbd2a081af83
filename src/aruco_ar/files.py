"""Writing files whole or not at all."""
import os
import tempfile

from .errors import InputError


def write_whole(path, data):
    """Write bytes to a file that appears only when it is complete.

    Makes the folder if there is none. Raises InputError naming the folder if
    it cannot be written.
    """
    folder = os.path.dirname(os.path.abspath(path))
    try:
        os.makedirs(folder, exist_ok=True)
        handle, draft = tempfile.mkstemp(dir=folder, prefix='.' + os.path.basename(path))
        try:
            with os.fdopen(handle, 'wb') as file:
                file.write(data)
            os.chmod(draft, 0o666 & ~_umask())  # mkstemp makes files private
            os.replace(draft, path)
        except BaseException:
            os.unlink(draft)
            raise
    except OSError as error:
        raise InputError('Cannot write "%s": %s. Choose another folder with --output.'
                         % (path, error.strerror))


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
