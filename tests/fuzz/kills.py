"""Kills at commit points: a command that is killed there leaves its old state or its new one, and can be repeated.

Each command is run once undisturbed, which counts its commit points: names that it makes, replaces or removes, files
that it opens to write, synchronisations, and statements of SQLite. It is then killed before each of them, or before a
seeded sample, and repeated::

    python tests/fuzz/kills.py [--seed 1] [--minutes 5] [--only train …] [--full] [--out counts.json]
"""

from __future__ import annotations

import argparse
import errno
import hashlib
import json
import os
import random
import re
import shutil
import signal
import sqlite3
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pyarrow.parquet import ParquetWriter

from tactogram.cli import main as tactogram
from tactogram.datasets import open_store, split_last
from tactogram.datasets.store import writer
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError

LEAST = 2
"""Kills of a command, however short the time is."""
EVENTS = {"os.rename", "os.remove", "os.link", "os.mkdir", "os.rmdir", "os.truncate"}
UNFINISHED = re.compile(
    r"""(^|/)\..*\.part | (^|/)[^/]+\.part-[^/]+/ | /adding-[^/]*\.txt$ | \.cues\.jsonl$ | -(wal|shm|journal)$
    | (^|/)(made|folds)/ | (^|/)(checkpoint\.safetensors|metrics\.jsonl)$ | (^|/)(shard|images|ratings|ids)-[^/]+$""",
    re.VERBOSE,
)
"""Files that are no result by themselves: checkpoints, and what a store has if dataset.json names it."""
DRAWN = re.compile(rb"-[0-9a-f]{8}(?=\.parquet)")
"""Part of the names of a store's files that is drawn."""
DIFFERS = re.compile(rb'"(answering_s|training_s)": ([0-9.e-]+|null),\s*|"finished": "[^"]*",\s*')
"""Facts of a result of the benchmark that are not the same twice. Of a session these are codes and times (`pages`)."""


@dataclass(frozen=True)
class Command:
    """A command line, in a folder of its own beside what `prepare` made, and how it is repeated after a kill."""

    words: tuple[str, ...]
    again: Callable[[], tuple[str, ...]] | None = None
    copied: tuple[str, ...] = ()
    """Folders that it changes, copied from those that `prepare` made."""
    kept: float | None = None
    """Seconds between the checkpoints of a store, if not the usual ones."""
    adds: bool = False
    """Whether repeating it adds to what is there, instead of completing it."""
    view: Callable[[Path], dict[str, str]] = field(default_factory=lambda: content)
    """What of a folder is compared."""
    says: str = "(?!)"
    """Pattern of the line that acknowledges something, whose group is in its name in the view."""


@dataclass
class Count:
    """What became of the kills of one command."""

    points: int = 0
    kills: int = 0
    lost: int = 0
    half_written: int = 0
    resumed_to_the_same_bytes: int = 0
    problems: list[str] = field(default_factory=list)


def prepare(folder: Path) -> None:
    """Make recordings, a store, runs, a task and a session that the commands use."""
    import soundfile

    from tactogram_capture.twelite.simulator import SimulatedReceiver, write_log

    write_log(folder / "raw.log", SimulatedReceiver(seconds=20, seed=1))
    rng = np.random.default_rng(0)
    for place, material in enumerate(("cork", "felt", "tile")):
        (folder / "recordings" / material).mkdir(parents=True)
        for take in range(4):
            sound = rng.normal(size=1000) * 0.01 * 2**place
            soundfile.write(folder / "recordings" / material / f"{take}.wav", sound, 1000, subtype="FLOAT")
    soundfile.write(folder / "new.wav", rng.normal(size=800) * 0.01, 1000, subtype="FLOAT")
    (folder / "ratings.csv").write_text("rater,item,word,score\na,cork,rough,2\na,felt,rough,3\n")
    (folder / "plan.toml").write_text(
        'materials = ["cork", "felt"]\nspeeds_mm_s = [100]\nrepetitions = 2\nseconds = 0.2\ncountdown_s = 0\n'
        "metronome = false\nrate = 330\n"
    )
    (folder / "conditions.csv").write_text(
        "file,material,seed\n" + "".join(f"{n}.wav,cork,{n}\n" for n in range(20))
    )
    with inside(folder):
        for words in (
            "data import folder recordings --out s --set unit=m/s^2 --workers 1",
            "data rate s ratings.csv",
            "train replay --data s --recipe tiny --out replay --accelerator cpu",
            "study simulate two-area --participants 1 --out session",
        ):
            if tactogram([*words.split(), "--quiet"]):
                raise RuntimeError(words)
    store = open_store(folder / "s")
    (folder / "tasks").mkdir()
    (folder / "stores").mkdir()
    (folder / "stores" / "s").symlink_to(folder / "s")
    split_last(store.index, 1, validation=1).save(folder / "tasks" / "split.json")
    sha256 = hashlib.sha256((folder / "tasks" / "split.json").read_bytes()).hexdigest()
    (folder / "tasks" / "name.toml").write_text(
        f'title = "name"\nkind = "classification"\nsplit = "split.json"\nsplit_sha256 = "{sha256}"\n'
        f'[data]\nname = "{store.name}"\nsha256 = "{store.sha256}"\nwhat = "noise"\nimporter = "folder"\n'
    )


def commands(base: Path) -> dict[str, Command]:
    """Return the commands by name; paths that are not absolute are in their own folder."""

    def of(line: str, **options: object) -> Command:
        return Command(tuple(line.format(base=base).split()), **options)  # type: ignore[arg-type]

    train = of(
        "train stroke_cnn --data {base}/s --recipe tiny --set training.checkpoint_every=2 --accelerator cpu --out run"
    )

    def resumed() -> tuple[str, ...]:
        return (*train.words, *(["--resume"] if Path("run/recipe.toml").exists() else []))

    return {
        "import": of("data import folder {base}/recordings --out s --set unit=m/s^2 --workers 1"),
        "import, kept": of(
            "data import folder {base}/recordings --out s --set unit=m/s^2 --workers 1", kept=0.0
        ),
        "add": of("data add s {base}/new.wav --material cork", copied=("s",)),
        "rate": of("data rate s {base}/ratings.csv --replace", copied=("s",)),
        "copy": of("data copy {base}/s copied"),
        "data export": of("data export {base}/s --out hub"),
        "simulate": of(
            "data simulate surfaces --random 3 --per-class 2 --seconds 0.2 --rate 1000 --raters 3 --workers 1 --out s"
        ),
        "train": replace(train, again=resumed),
        "crossval": of(
            "crossval stroke_statistics --data {base}/s --folds 3 --recipe tiny --out cv --processes 1"
        ),
        "evaluate": of("evaluate replay", copied=("replay", "s")),
        "run export": of("run export {base}/replay --out run.zip"),
        "generate": of("generate {base}/replay --material cork --seconds 0.2 --out g.wav"),
        "generate --conditions": of(
            "generate {base}/replay --conditions {base}/conditions.csv --seconds 0.2 --out many --processes 1"
        ),
        "render": of(
            "render {base}/new.wav --unit m/s^2 --display voice-coil --level physical --out drive.wav"
        ),
        "benchmark run": of(
            "benchmark run name stroke_cnn --seeds 1 --recipe tiny --folder work "
            "--tasks {base}/tasks --stores {base}/stores"
        ),
        "capture": of(
            "capture {base}/plan.toml --source log:{base}/raw.log --data touched --yes --silent",
            view=takes,
            says=r"take (\d+) of .*-> accept",
        ),
        "study simulate": of("study simulate two-area --participants 2 --out session", adds=True),
        "study export": of("study export {base}/session --out answers.csv"),
        "study export --bids": of("study export {base}/session --bids bids"),
    }


class inside:  # noqa: N801
    """The working folder of a block."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.before = folder, Path.cwd()

    def __enter__(self) -> None:
        os.chdir(self.folder)

    def __exit__(self, *_: object) -> None:
        os.chdir(self.before)


def run(
    command: Command, folder: Path, words: tuple[str, ...], *, at: int = 0, full: bool = False
) -> tuple[int, int, str]:
    """Run a command line in a forked process; return its exit status (-9: killed), its commit points and its output.

    It is killed before the commit point numbered ``at``, from 1, or finds the disk ``full`` from there on.
    """
    reading, writing = os.pipe()
    log = Path(tempfile.gettempdir()) / f"tactogram-kills-{os.getpid()}.log"
    child = os.fork()
    if child == 0:
        status = 70
        try:
            os.close(reading)
            out = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
            os.dup2(out, 1)
            os.dup2(out, 2)
            os.chdir(folder)
            count_points(folder, at, writing, full)
            if command.kept is not None:
                writer.KEPT_S = command.kept
            status = tactogram([*words, "--quiet"])
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stderr.flush()
            os._exit(status)
    os.close(writing)
    points = 0
    while got := os.read(reading, 1 << 16):
        points += len(got)
    os.close(reading)
    _, ended = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(ended), points, log.read_text(errors="replace")


def count_points(folder: Path, at: int, pipe: int, full: bool) -> None:
    """Write a byte to a pipe before every commit point in ``folder``, and kill this process or fill the disk at one."""
    count = 0

    def point(*, takes_space: bool = True) -> None:
        nonlocal count
        count += 1
        if full and takes_space and count >= at:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if not full and count == at:
            os.kill(os.getpid(), signal.SIGKILL)
        os.write(pipe, b".")

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        writes = (
            event == "open" and isinstance(arguments[2], int) and arguments[2] & (os.O_WRONLY | os.O_RDWR)
        )
        named = (writes or event in EVENTS) and isinstance(arguments[0], str | bytes | os.PathLike)
        if named and os.path.abspath(os.fsdecode(arguments[0])).startswith(f"{folder}/"):
            point(takes_space=event in ("open", "os.mkdir"))

    def counted(owner: Any, name: str) -> None:
        real = getattr(owner, name)

        def call(*arguments: Any, **options: Any) -> Any:
            point()
            return real(*arguments, **options)

        setattr(owner, name, call)

    def connected(*arguments: Any, **options: Any) -> sqlite3.Connection:
        connection = connect(*arguments, **options)
        connection.set_trace_callback(lambda _: point(takes_space=False))
        return connection

    connect, sqlite3.connect = sqlite3.connect, connected
    for owner, name in ((os, "fsync"), (ParquetWriter, "write_table"), (ParquetWriter, "close")):
        counted(owner, name)
    sys.addaudithook(hook)


def content(folder: Path) -> dict[str, str]:
    """Return the hash of each file in a folder by its name, without what deliberately differs."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_dir():
            found |= {} if any(path.iterdir()) else {f"{name}/": "empty"}
            continue
        if name.endswith(".sqlite"):
            found |= {f"{name} {page}": "stored" for page in pages(path)}
        elif not name.endswith(("-wal", "-shm", "training_s.txt")):
            raw = path.read_bytes()
            if path.suffix == ".json":
                raw = DRAWN.sub(b"", DIFFERS.sub(b"", raw))
            name = DRAWN.sub(b"", name.encode()).decode()
            found[name] = hashlib.sha256(raw).hexdigest()[:16]
    return found


def takes(folder: Path) -> dict[str, str]:
    """Return how often a recording session's store has each take, and the files beside it that it does not name."""
    files = {path.relative_to(folder).as_posix() for path in folder.glob("touched*/*") if path.is_file()}
    if not (folder / "touched").exists():
        return dict.fromkeys(files, "unnamed")
    store = open_store(folder / "touched")
    named = {"dataset.json", store.facts.ids, *(stored.file for stored in store.facts.files)}
    count = Counter(f"take {info.labels['trial']}" for info in store.index)
    unnamed = files - {f"touched/{name}" for name in named}
    return {name: str(times) for name, times in count.items()} | dict.fromkeys(unnamed, "unnamed")


def pages(path: Path) -> list[str]:
    """Return the answered pages in a session, without codes and times; raise if it is damaged."""
    with tempfile.TemporaryDirectory() as copy:  # whose log SQLite may replay
        for each in path.parent.glob(f"{path.name}*"):
            shutil.copy(each, copy)
        with closing(sqlite3.connect(Path(copy) / path.name)) as connection:
            [(state,)] = connection.execute("PRAGMA integrity_check")
            if state != "ok":
                raise ValueError(f"{path}: {state}")
            if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'pages'").fetchone():
                return []
            found = connection.execute("SELECT participant, position, responses FROM pages ORDER BY 1, 2")
            return [repr(page) for page in found]


def killed_everywhere(
    command: Command, base: Path, folder: Path, *, points: Callable[[int], Iterator[int]], full: bool = False
) -> Count:
    """Kill a command before its commit points, check what is left, repeat it, and compare with an undisturbed one.

    With a ``full`` disk instead, it must also say so in one line.
    """

    def fresh() -> dict[str, str]:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        for name in command.copied:
            shutil.copytree(base / name, folder / name)
        return command.view(folder)

    old = fresh()
    status, _, said = run(command, folder, command.words)
    count = Count()
    if status:
        count.problems.append(f"undisturbed: status {status}: {said[-400:]}")
        return count
    new = command.view(folder)
    fresh()
    status, every, _ = run(command, folder, command.words)  # the first time modules may be compiled
    count.points = every
    if status or command.view(folder) != new:
        count.problems.append(f"twice: {difference(new, command.view(folder))}")
    for at in points(every):
        fresh()
        status, _, said = run(command, folder, command.words, at=at, full=full)
        left = command.view(folder)
        if status == 0 and (command.adds or left == new):
            continue
        count.kills += 1
        if full and not re.search(r"^(tactogram|NOT stored): [^\n]*No space left", said, re.MULTILINE):
            count.problems.append(f"point {at}: status {status}, {said[-400:]}")
        half = [
            name
            for name, hash in left.items()
            if not name.endswith("/")
            and not UNFINISHED.search(name)
            and hash not in (old.get(name), new.get(name))
        ]
        half += [line for facts in folder.rglob("dataset.json") for line in faults(facts.parent)]
        lost = [name for name in old if name in new and name not in left]
        lost += [
            f"take {number}" for number in re.findall(command.says, said) if f"take {number}" not in left
        ]
        count.half_written += bool(half)
        count.lost += bool(lost)
        with inside(folder):
            again = command.again() if command.again else command.words
        status, _, said = run(command, folder, again)
        after = command.view(folder)
        # A command may refuse a result that is there already.
        same = (status == 0 or left == new) and (command.adds or after == new)
        lost += [name for name in left if command.adds and name not in after]
        count.resumed_to_the_same_bytes += same
        if half or lost or not same:
            repeated = "" if same else f"status {status}, {said[-400:]}, {difference(new, after)}"
            count.problems.append(f"point {at}: half-written {half}, lost {lost}, repeated {repeated}")
    return count


def faults(store: Path) -> list[str]:
    """Return what is wrong with a store, nothing of one that is being made."""
    try:
        return [] if ".part-" in str(store) else problems(open_store(store))
    except DataError as error:
        return [str(error)]


def difference(one: dict[str, str], other: dict[str, str]) -> str:
    """Return the names of files that are in one folder only, or differ."""
    return ", ".join(
        f"{'-' if name not in other else '+' if name not in one else '!'}{name}"
        for name in sorted({*one, *other})
        if one.get(name) != other.get(name)
    )


def main() -> int:
    """Kill every command; 1 if anything was lost, half-written, or not completed by repeating it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--only", nargs="*", help="names of commands, by default all")
    parser.add_argument("--full", action="store_true", help="a full disk instead of a kill")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    until = time.monotonic() + 60 * options.minutes
    counts = {}
    with tempfile.TemporaryDirectory(prefix="tactogram-kills-") as folder:
        base = Path(folder).resolve() / "base"
        base.mkdir()
        prepare(base)
        known = commands(base)
        chosen = {name: known[name] for name in options.only or known}
        rng = random.Random(options.seed)
        for place, (name, command) in enumerate(chosen.items()):
            share = (until - time.monotonic()) / (len(chosen) - place)
            counts[name] = killed_everywhere(
                command,
                base,
                base.with_name("work"),
                points=partial(drawn, rng, time.monotonic() + share),
                full=options.full,
            )
            sys.stdout.write(f"{name}: {counts[name]}\n")
            sys.stdout.flush()
    if options.out:
        options.out.write_text(json.dumps({n: vars(c) for n, c in counts.items()}, indent=1) + "\n")
    return int(any(count.problems for count in counts.values()))


def drawn(rng: random.Random, until: float, every: int) -> Iterator[int]:
    """Yield the numbers of all points in a drawn order until the time is over, but at least `LEAST`."""
    for done, at in enumerate(rng.sample(range(1, every + 1), every)):
        if done >= LEAST and time.monotonic() > until:
            return
        yield at


if __name__ == "__main__":
    sys.exit(main())
