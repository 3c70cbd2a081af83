"""How the process handles memory of the size of frames."""
import ctypes

# Of glibc's malloc.h.
M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_THRESHOLD, M_ARENA_MAX = -1, -2, -3, -8
LIMIT_BYTES = 1 << 30
PAD_BYTES = 16 << 20


def keep_memory():
    """Have the process keep the memory of a frame for the next one.

    Otherwise glibc gives every block of that size back to the kernel, and gets
    it back page by page, which costs more than what is done with the frame.
    Where the C library is another, nothing changes.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):
        return
    for option, value in ((M_MMAP_THRESHOLD, LIMIT_BYTES), (M_TRIM_THRESHOLD, LIMIT_BYTES),
                          (M_TOP_PAD, PAD_BYTES), (M_ARENA_MAX, 1)):
        mallopt(option, value)
