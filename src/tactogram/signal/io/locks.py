"""Files that one process at a time may hold; the system lets go when a process ends, however it ends."""

from __future__ import annotations

import os
import sys


def lock(opened: int, *, shared: bool = False) -> bool:
    """Lock a file until it is closed, and say whether that went; nothing is waited for.

    Parameters
    ----------
    opened : int
        Descriptor of the open file. What is opened twice is held twice, by one process too.
    shared : bool
        Let others hold it who ask so as well; on Windows nobody.

    Raises
    ------
    OSError
        If the file system has no locks.
    """
    # Each module is there on one kind of system only.
    if sys.platform == "win32":
        import msvcrt

        os.lseek(opened, 1 << 30, os.SEEK_SET)  # behind the end: what is locked cannot be read there
        try:
            msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(opened, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
