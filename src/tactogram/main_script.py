"""Main script: whether processes that start now would run it again; their end with it."""

from __future__ import annotations

import ast
import os
import signal
import sys
from multiprocessing import connection, parent_process
from pathlib import Path
from threading import Thread, main_thread
from time import sleep

from tactogram.errors import ParameterError


def allowed_processes(asked: int | None, default: int) -> int:
    """Return the number of processes ``asked`` for, or the default; only one where more would run the script again.

    Raises `ParameterError` if several were asked for there.
    """
    line = None if asked == 1 else repeated_line()
    if line is None:
        return asked or default
    if asked is None:
        return 1
    raise ParameterError(
        f"{sys.modules['__main__'].__file__}: line {line} must be below `if __name__ == '__main__':` for {asked} "
        "processes, since each would run it again; add that, or ask for 1"
    )


def repeated_line() -> int | None:
    """Return the line of the main script that runs now, if processes that start would run it again; else None.

    They import the script, so that all its statements run again but those below ``if __name__ == "__main__":`` or
    another condition (`multiprocessing`, "Safe importing of main module").
    """
    main = sys.modules["__main__"]
    path, spec = getattr(main, "__file__", None), getattr(main, "__spec__", None)
    if path is None or (spec is not None and spec.name.endswith("__main__")):
        return None
    line, frame = None, sys._current_frames().get(main_thread().ident or 0)
    while frame is not None:
        if frame.f_globals is vars(main) and frame.f_code.co_name == "<module>":
            line = frame.f_lineno
        frame = frame.f_back
    try:
        statements = [] if line is None else ast.parse(Path(path).read_bytes()).body
    except (OSError, SyntaxError, ValueError):
        return None
    running = [each for each in statements if each.lineno <= (line or 0) <= (each.end_lineno or 0)]
    return line if running and not isinstance(running[0], ast.If) else None


def start_worker(ends: connection.Connection | None = None, *, parent_id: int | None = None) -> None:
    """Leave interrupts to the parent, and end with it: a killed import must not leave processes behind.

    With ``ends`` the process also ends when the other side of that pipe is closed, whatever it is doing. ``parent_id``
    is the parent of a program, which `multiprocessing` does not know.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            connection.wait([parent.sentinel, *([] if ends is None else [ends])])
        while parent is None and os.getppid() == parent_id:
            sleep(1)
        os._exit(1)

    Thread(target=end_with_parent, daemon=True).start()
