"""File locks, which the system releases when a process ends for whatever reason."""

from __future__ import annotations

import os
import sys


def lock(opened: int, *, shared: bool = False) -> bool:
    """Lock the open file of a descriptor until it is closed, without waiting; return whether it is locked.

    A file that is opened twice is locked separately, even by one process. Other ``shared`` locks are allowed, except on
    Windows. A file system without locks raises an OSError.
    """
    # Each module exists on one kind of system only.
    if sys.platform == "win32":
        import msvcrt

        os.lseek(opened, 1 << 30, os.SEEK_SET)  # behind the end, since locked bytes cannot be read
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
