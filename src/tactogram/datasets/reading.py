"""Parallel reading of many files, in order and in little memory; what is said of many of them, in one line each."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from multiprocessing import get_context
from time import monotonic
from typing import Any

from tactogram.datasets.examples import cores
from tactogram.datasets.importer import ImportItem, LeftOut, importer
from tactogram.datasets.recording import Recording
from tactogram.errors import DataError, Message, ParameterError, TactogramError
from tactogram.main_script import allowed_processes, start_worker
from tactogram.signal.io.archives import reason

Reading = Sequence[Recording | LeftOut] | Message
"""Recordings of an item and its parts that are none, or one line on what is wrong with it."""
PATIENCE_S = 2.0
"""What starting processes costs: less is read before they would be ready."""
MOST_NAMES = 3
_VARIES = re.compile(r"'[^']*'|\"[^\"]*\"|[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def read_all(
    importer_name: str,
    items: Sequence[ImportItem],
    workers: int | None,
    progress: Callable[[int, int], None],
) -> Generator[tuple[ImportItem, Reading]]:
    """Yield each item, in order, with its recordings or with one line on what is wrong with it.

    By default this process reads alone for `PATIENCE_S`, then one process per core, unless these would run the main
    script again (`tactogram.main_script`). Only a few items per process are in
    progress at a time, so that memory stays flat. A process that dies is a `DataError`.
    """
    if workers is not None and workers < 1:
        raise ParameterError.must("workers", "be >= 1", workers)
    if allowed_processes(workers, cores()) == 1:
        workers = 1
    started, done = monotonic(), 0
    while done < len(items) and (
        workers == 1 or (workers is None and (cores() == 1 or monotonic() - started < PATIENCE_S))
    ):
        yield items[done], read_item(importer_name, items[done])
        done += 1
        progress(done, len(items))
    if done == len(items):
        return
    workers = min(workers or cores(), len(items) - done)
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=start_worker)
    try:
        pending: deque[tuple[ImportItem, Future[Reading]]] = deque()
        rest = iter(items[done:])
        while done < len(items):
            for item in islice(rest, 3 * workers - len(pending)):
                pending.append((item, pool.submit(read_item, importer_name, item)))
            item, future = pending.popleft()
            try:
                yield item, future.result()
            except BrokenProcessPool as error:
                raise DataError(
                    item.name,
                    "a process died while reading this or a neighbouring item, perhaps out of memory; "
                    "try workers=1",
                ) from error
            done += 1
            progress(done, len(items))
    finally:
        pool.shutdown(cancel_futures=True)


def read_item(importer_name: str, item: ImportItem) -> Reading:
    """Return the recordings of an item, or one line on what is wrong with it."""
    try:
        for path in item.paths:
            if not path.is_file():
                return Message(f"missing, though {item.name} needs it", place=path)
            if path.stat().st_size == 0:
                return Message("empty file", place=path)
        recordings = importer(importer_name).read(item)
    except TactogramError as error:
        return error.message if item.name in error.message.place else Message(error.message, place=item.name)
    except Exception as error:  # whatever a reader trips over, the user needs the name of the file
        return Message(f"not readable{reason(error)}", place=item.name)
    return recordings or Message("holds no recording", place=item.name)


def by_kind(messages: Iterable[tuple[str, str]]) -> list[dict[str, Any]]:
    """Return what is said of files (name, message), each kind once: ``text``, ``count`` and ``files``, the first ones.

    Messages are alike but for names of files, numbers and what is quoted. The text of several is that of the first
    without its file's name.
    """
    kinds: dict[str, dict[str, Any]] = {}
    for name, message in messages:
        plain = _without(message, name)
        key = _VARIES.sub("#", plain)
        kind = kinds.setdefault(key, {"text": plain, "count": 0, "files": []})
        kind["count"] += 1
        if len(kind["files"]) < MOST_NAMES and name not in kind["files"]:
            kind["files"].append(name)
    return list(kinds.values())


def in_one_line(kind: dict[str, Any]) -> str:
    """Return a kind with the number of its messages and the names of its first files."""
    files, count = ", ".join(kind["files"]), kind["count"]
    if count == 1:
        return f"{files}: {kind['text']}" if files else str(kind["text"])
    what = "parts" if "#" in files else "files"
    return f"{count} {what}: {kind['text']} ({files}{', …' * (count > len(kind['files']))})"


def _without(message: str, name: str) -> str:
    """Return a message without its file, if ``name`` is that file, its end or a part of it."""
    if not isinstance(message, Message):
        return message
    file, location = name.partition("#")[0], message.place.partition(": ")[0]
    return message.within(location) if file and location.partition("#")[0].endswith(file) else message
