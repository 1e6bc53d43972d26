"""Fuzzer of the readers: damaged inputs of every kind, and what the command line makes of them.

``python -m tests.fuzz.readers --seed 1 --minutes 10`` damages one file of a small valid input, seeded, and runs a verb
on it in a forked process, within limits of time and memory. A finding is an exit other than 0, 1 and 2, a traceback, a
message in words of Python, a hang, much memory, or anything written or changed although the verb failed.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path
from random import Random

from tests.object_store import object_store

from tactogram.datasets.store.remote import location

BUCKET = "s3://bucket/"
CASES = Path(__file__).parent / "cases"
MOST_SECONDS = 20
"""Of processor time; the clock may take three times as long on a busy machine."""
MOST_BYTES = 2 * 2**30
PYTHON = re.compile(
    r"\b(?:(?!Memory)[A-Z]\w+Error:|NoneType|object has no attribute|unhashable|not subscriptable|not iterable"
    r"|object is not|unsupported operand|not supported between|positional argument|unexpected keyword|out of range$"
    r"|<class|dtype\(|numpy\.|torch\.|size mismatch for)"
)
"""What a message to people does not hold."""
COMMANDS = {
    "convert-signal": "convert {signals} out.wav --rate 500",
    "convert-table": "convert {signals} out.csv",
    "check-signal": "convert {signals} --check",
    "haptic": "convert {haptic} out.ahap",
    "haptic-wave": "convert {haptic} out.wav --rate 2000",
    "check-haptic": "convert {haptic} --check",
    "picture": "convert {pictures} out.wav --play-at 100",
    "preview": "data import folder recordings --preview",
    "mapping": "data import folder recordings --mapping settings/mapping.toml --out out --workers 1",
    "import-folder": "data import folder recordings --out out --workers 1",
    **{
        f"import-{name}": f"data import {name} {name} --out out --workers 1{options}"
        for name, options in {
            "biotac_slide": "",
            "cdplab": "",
            "cluster": "",
            "frictgan": "",
            "haptex": "",
            "hatt": "",
            "keio_ultrasonic": " --set rate=2500 --set full_scale=2.0",
            "lmt108": "",
            "saga_strokes": "",
            "vibviz": "",
        }.items()
    },
    "store-info": "data info store",
    "store-url": "data info file://{work}/store",
    "s3-info": "data info s3://bucket/store",
    "s3-check": "data check s3://bucket/store",
    "s3-copy": "data copy s3://bucket/store out",
    "s3-send": "data copy store s3://bucket/sent",
    "s3-train": "train ar_texture --data s3://bucket/store --recipe settings/recipe.toml --out out",
    "store-check": "data check store",
    "store-export": "data export store --out out",
    "store-copy": "data copy store out",
    "store-like": "data like store signals/own.wav",
    "store-add": "data add store waves/a.wav --material cork",
    "store-rate": "data rate store tables/ratings.csv --replace",
    "store-ratings": "data ratings store --out out.csv",
    "train": "train ar_texture --data store --recipe settings/recipe.toml --out out",
    "crossval": (
        "crossval stroke_statistics --data store --folds 2 --recipe settings/names.toml --out out --processes 1"
    ),
    "clone": "clone waves/a.wav --out out --speeds 100 --forces 1 --seconds 0.3",
    "classify": "classify names recordings/cork/1.wav",
    "classify-network": "classify network recordings/cork/1.wav",
    "search": "search names recordings/cork/1.wav",
    "score": "score judge recordings/cork/1.wav",
    "evaluate": "evaluate names --data other",
    "evaluate-generator": "evaluate textures --data other --evaluation steps=2 --evaluation most=1",
    "generate": "generate textures --material cork --seconds 0.2 --out out.wav",
    "conditions-toml": "generate textures --conditions settings/conditions.toml --out out --processes 1",
    "conditions-csv": "generate textures --conditions settings/conditions.csv --out out --processes 1",
    "mix": "mix textures cork tile --steps 2 --signals 2 --seconds 0.6 --out out",
    "run-zip": "run export names --out out.zip",
    "run-hub": "run export textures --to hub --out out",
    "run-c": "run export noise --to c --material cork --out out.h",
    "run-import": "run import packed/names.zip --out out",
    "compare": "compare names network",
    "run-onnx": "run export network --to onnx --out out.onnx",
    "touch": "touch {waves} --out out.json",
    "stream": "stream waves/a.wav --speed 100 --seconds 0.1 --motion tables/motion.csv --backend file --out out.wav",
    "display": "render waves/a.wav --display settings/display.toml --level gain=0.1 --out out.wav",
    "calibration": (
        "render waves/a.wav --display electrovibration --level peak=0.5 --calibration calibrated/p.toml --out out.wav"
    ),
    "response": "response sweep/sweep.wav sweep/sweep.wav --out out.csv",
    "calibrate": "calibrate tables/pairs.csv --out out.toml",
    "transducer": "transducer tables/admittance.csv",
    "log": "capture-log {logs} --out out.csv",
    "log-store": "capture-log {logs} --data out --material cork",
    "capture": "capture settings/plan.toml --source log:logs/raw.log --data out --yes --silent",
    "live": "live network --source log:logs/text.txt --window 0.3 --hop 0.1",
    "study": "study check settings/study.toml",
    "study-simulate": "study simulate settings/study.toml --out out --participants 1",
    "study-export": "study export session --out out.csv",
    "study-analyse": "study analyse answers/answers.csv --out out --draws 100 --no-figures",
}
"""Verbs by a name of ours; a word that begins with a part of the corpus is its copy, ``{part}`` one file of it."""
HEAVY = {
    "evaluate-generator",
    "run-onnx",
    "mix",
    "evaluate",
    "run-c",
    "touch",
    "import-hatt",
    "clone",
    "crossval",
}
"""Verbs that take seconds, and are run more rarely."""
MAY_WRITE = {"study-export": "session", "capture": "out"}
"""Beginning of what a verb that fails may change: a database that opening touches; takes, each kept as it is made."""


@dataclass(frozen=True)
class Trial:
    """One damaged input: the words of the verb, the file that is damaged, and its content, or its kind."""

    target: str
    argv: tuple[str, ...]
    victim: str
    content: bytes | str


@dataclass(frozen=True)
class Outcome:
    """What a verb made of it."""

    status: int
    """Exit status, negative for a signal."""
    seconds: float
    peak: int
    text: str
    changed: tuple[str, ...]

    @property
    def faults(self) -> list[str]:
        """Findings by kind."""
        slow = self.status in (-signal.SIGALRM, -signal.SIGPROF, -signal.SIGKILL)
        last = (self.text.strip().splitlines() or [""])[-1]
        found = {
            "hang": slow,
            "crash": self.status < 0 and not slow,
            "exit": self.status > 2,
            "traceback": "Traceback (most recent" in self.text,
            "memory": self.peak > MOST_BYTES
            or "not enough memory" in self.text
            or "Unable to allocate" in self.text,
            "left": self.status != 0 and bool(self.changed),
            "silent": self.status == 1 and not last,
            "python": self.status == 1 and PYTHON.search(last) is not None,
            "warning": re.search(r"\.py:\d+: \w*Warning", self.text) is not None,
        }
        return [kind for kind, yes in found.items() if yes]


class Bench:
    """The corpus, made on demand, and a folder to work in."""

    def __init__(self, folder: Path, *, forks: bool = True) -> None:
        self.corpus, self.work, self.forks = folder / "corpus", folder / "work", forks
        self.said = folder / "said.txt"
        self.corpus.mkdir(parents=True, exist_ok=True)

    def part(self, name: str) -> Path:
        """Return a part of the corpus."""
        from tests.fuzz.corpus import NEEDS, PARTS

        for needed in NEEDS.get(name, ()):
            self.part(needed)
        if not (folder := self.corpus / name).exists():
            folder.mkdir()
            if not self.forks:
                PARTS[name](folder)
            elif pid := os.fork():  # what making it leaves behind, as threads, is not inherited by the trials
                assert os.waitpid(pid, 0)[1] == 0, f"{name} was not made"
            else:
                with _exiting():
                    PARTS[name](folder)
        return folder

    def words(self, target: str, rng: Random) -> tuple[str, ...]:
        """Return the arguments of a verb, with one file of each part that is to be drawn."""
        return tuple(
            re.sub(r"\{(\w+)\}", lambda m: f"{m[1]}/{rng.choice(_files(self.part(m[1])))}", word)
            for word in COMMANDS[target].replace("{work}", str(self.work)).split()
        )

    def places(self, argv: Sequence[str]) -> list[str]:
        """Return the words that are places in the corpus, whose parts are made."""
        from tests.fuzz.corpus import PARTS

        words = [re.sub(f"^(file://{self.work}/|{BUCKET}|log:)", "", each) for each in argv[1:]]
        return [word for word in words if (name := word.split("/")[0]) in PARTS and self.part(name)]

    def victims(self, argv: Sequence[str]) -> list[str]:
        """Return the files that a verb reads, by their place in the corpus."""
        folders = {word: self.corpus / word for word in self.places(argv)}
        return [
            file
            for word, place in folders.items()
            for file in ([f"{word}/{each}" for each in _files(place)] if place.is_dir() else [word])
        ]

    def copied(self, argv: Sequence[str]) -> None:
        """Copy what a verb reads into an empty working folder."""
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir()
        for word in self.places(argv):
            name, _, inner = word.partition("/")
            if inner and name in ("signals", "haptic", "pictures", "logs", "waves"):
                (self.work / name).mkdir(exist_ok=True)
                shutil.copy(self.corpus / word, self.work / word)
            elif not (self.work / name).exists():
                shutil.copytree(self.corpus / name, self.work / name)

    def trial(self, number: int, seed: int, targets: Sequence[str]) -> Trial:
        """Return the trial of this number."""
        from tests.fuzz.mutations import damaged

        rng = Random(f"{seed}-{number}")
        [target] = rng.choices(targets, [0.1 if name in HEAVY else 1.0 for name in targets])
        argv = self.words(target, rng)
        files = self.victims(argv)
        tops = sorted({file.split("/")[0] for file in files})
        victim = rng.choice(
            [file for top in [rng.choice(tops)] for file in files if file.split("/")[0] == top]
        )
        if rng.random() < 0.02:
            return Trial(target, argv, victim, rng.choice(ODD))
        return Trial(target, argv, victim, damaged((self.corpus / victim).read_bytes(), victim, rng))

    def prepared(self, trial: Trial) -> dict[str, tuple[int, int]]:
        """Put the damaged file into its place, and return the state of all files."""
        self.copied(trial.argv)
        _replace(self.work / trial.victim, trial.content)
        if any(word.startswith(BUCKET) for word in trial.argv):
            _send(self.work)
        return _state(self.work)

    def changed(self, before: dict[str, tuple[int, int]]) -> list[str]:
        """Return the files that are not as they were."""
        after = _state(self.work)
        return sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))

    def run(self, trial: Trial) -> Outcome:
        """Run a trial in a process of its own."""
        [outcome] = self.runs([trial])
        return outcome

    def runs(self, batch: Sequence[Trial]) -> Iterator[Outcome]:
        """Run trials in a forked process, of which a new one goes on where it ends in one of them."""
        done = 0
        while done < len(batch):
            reading, writing = os.pipe()
            if not (pid := os.fork()):
                with _exiting(), open(writing, "w") as told:
                    _limit(self.work.parent)
                    for trial in batch[done:]:
                        told.write(json.dumps(asdict(self._attempt(trial))) + "\n")
                        told.flush()
            os.close(writing)
            with open(reading) as lines:
                for line in lines:
                    done += 1
                    yield Outcome(**json.loads(line))
            _, status, usage = os.wait4(pid, 0)
            with suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL)  # processes of its own
            if done < len(batch):
                done += 1
                code, text = os.waitstatus_to_exitcode(status), self.said.read_text(errors="replace")
                yield Outcome(code, 0.0, usage.ru_maxrss * 1024, text, ("unknown",))

    def _attempt(self, trial: Trial) -> Outcome:
        """Run a trial in this process."""
        before = self.prepared(trial)
        os.chdir(self.work)
        said = os.open(self.said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(said, 1)
        os.dup2(said, 2)
        os.close(said)
        Path("/proc/self/clear_refs").write_text("5")  # the peak from now on
        began = time.monotonic()
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
        signal.alarm(3 * MOST_SECONDS)
        code = _status_of([*trial.argv, "--quiet"])
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.alarm(0)
        seconds = time.monotonic() - began
        peak = re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())
        kept = MAY_WRITE.get(trial.target, "\0")
        changed = [name for name in self.changed(before) if not name.startswith(kept)]
        text = self.said.read_text(errors="replace")
        return Outcome(code, seconds, int(peak[1]) * 1024 if peak else 0, text, tuple(changed))


ODD = ("folder", "pipe", "zero", "dangling", "loop", "gone", "flat")
"""What may be in the place of a file, or (``flat``) a file in the place of its folder."""


def _replace(path: Path, content: bytes | str) -> None:
    path.unlink()
    match content:
        case bytes():
            path.write_bytes(content)
        case "folder":
            path.mkdir()
        case "pipe":
            os.mkfifo(path)
        case "flat":
            shutil.rmtree(path.parent)
            path.parent.write_bytes(b"x")
        case "zero" | "dangling" | "loop":
            path.symlink_to({"zero": "/dev/zero", "dangling": "nowhere", "loop": path.name}[content])


def _send(folder: Path) -> None:
    """Put the files of a folder into the bucket, in place of all others."""
    place = location(BUCKET)
    place.system.delete_dir_contents(place.path)
    for name in _files(folder):
        with place.system.open_output_stream(f"{place.path}/{name}") as out:
            out.write((folder / name).read_bytes())


def _files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def _state(folder: Path) -> dict[str, tuple[int, int]]:
    paths = [path for path in folder.rglob("*") if not path.name.endswith(".lock")]
    return {
        str(path.relative_to(folder)): (facts.st_ino, facts.st_mtime_ns if path.is_file() else 0)
        for path in paths
        for facts in [path.lstat()]
    }


@contextmanager
def _exiting() -> Iterator[None]:
    """Leave a forked process, whatever happens."""
    code = 1
    try:
        yield
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        if modules := os.environ.get("FUZZ_MODULES"):
            Path(modules).write_text("\n".join(sys.modules))
        os._exit(code)


def _status_of(argv: Sequence[str]) -> int:
    """Return the exit status that a process of these words would have."""
    from tactogram.cli import main

    sys.argv = ["tactogram", *argv]
    try:
        code = main()
    except SystemExit as left:
        code = left.code if isinstance(left.code, int) else 0
    except BaseException:
        traceback.print_exc()
        code = 70
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def _limit(temporary: Path) -> None:
    os.setpgid(0, 0)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = os.fdopen(1, "w", closefd=False)
    sys.stderr = os.fdopen(2, "w", closefd=False)
    os.environ["TMPDIR"] = str(temporary)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + 4 * MOST_BYTES,) * 2)
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_BYTES,) * 2)


def warm(bench: Bench, targets: Sequence[str]) -> None:
    """Import once what the verbs import: a valid input of each is run, and says which modules it needed."""
    for target in targets:
        argv = bench.words(target, Random(0))
        victim = bench.victims(argv)[0]
        modules = bench.work.with_suffix(".modules")
        os.environ["FUZZ_MODULES"] = str(modules)
        outcome = bench.run(Trial(target, argv, victim, (bench.corpus / victim).read_bytes()))
        assert outcome.status == 0, f"{target}: a valid input fails: {outcome.text}"
        for name in modules.read_text().split():
            with suppress(Exception):
                import_module(name)
    del os.environ["FUZZ_MODULES"]
    gc.freeze()  # a collection in a fork would copy every page


def save(trial: Trial, outcome: Outcome, folder: Path) -> None:
    """Write a finding as a case."""
    folder.mkdir(parents=True, exist_ok=True)
    content = trial.content
    facts = {
        "target": trial.target,
        "argv": trial.argv,
        "victim": trial.victim,
        "kind": content if isinstance(content, str) else "",
        "faults": outcome.faults,
        "status": outcome.status,
        "peak_mib": outcome.peak >> 20,
        "seconds": round(outcome.seconds, 1),
        "changed": outcome.changed[:20],
        "says": outcome.text[-1500:],
    }
    (folder / "how.json").write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n")
    if isinstance(content, bytes):
        (folder / Path(trial.victim).name).write_bytes(content)


def load(folder: Path) -> Trial:
    """Return a case that `save` wrote."""
    facts = json.loads((folder / "how.json").read_text())
    content = facts["kind"] or (folder / Path(facts["victim"]).name).read_bytes()
    return Trial(facts["target"], tuple(facts["argv"]), facts["victim"], content)


def trials(
    bench: Bench, seed: int, targets: Sequence[str], minutes: float, most: int
) -> Iterator[tuple[int, Trial]]:
    """Yield trials until the time or the number is over."""
    end = time.monotonic() + 60 * minutes
    for number in range(most):
        if time.monotonic() > end:
            return
        yield number, bench.trial(number, seed, targets)


def fuzz(
    bench: Bench, seed: int, *, minutes: float, most: int = 10**9, only: str = "", out: Path | None = None
) -> dict:
    """Run trials, save what is found, and return the counts."""
    targets = [name for name in COMMANDS if re.search(only, name)]
    warm(bench, targets)
    inputs: Counter[str] = Counter()
    found: dict[str, Counter[str]] = {name: Counter() for name in targets}
    slowest, largest = 0.0, 0

    def counts() -> dict:
        return {
            "seed": seed,
            "inputs": inputs.total(),
            "findings": dict(sum(found.values(), Counter())),
            "slowest_s": round(slowest, 1),
            "largest_mib": largest >> 20,
            "by_target": {name: {"inputs": inputs[name], **found[name]} for name in targets},
        }

    for batch in batched(trials(bench, seed, targets, minutes, most)):
        for (number, trial), outcome in zip(batch, bench.runs([trial for _, trial in batch]), strict=True):
            inputs[trial.target] += 1
            slowest, largest = max(slowest, outcome.seconds), max(largest, outcome.peak)
            for fault in outcome.faults:
                found[trial.target][fault] += 1
            if outcome.faults and out is not None:
                save(trial, outcome, out / f"{trial.target}-{number}-{'-'.join(outcome.faults)}")
        if out is not None:
            write(counts(), out)
    return counts()


def batched(numbered: Iterator[tuple[int, Trial]], count: int = 25) -> Iterator[list[tuple[int, Trial]]]:
    """Yield the trials of a process each."""
    while batch := list(islice(numbered, count)):
        yield batch


def write(counts: dict, out: Path) -> None:
    """Write the counts into the folder of findings."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "counts.json").write_text(json.dumps(counts, indent=1) + "\n")


def main() -> int:
    """Run the fuzzer; return 1 if it found something."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--most", type=int, default=10**9, help="inputs")
    parser.add_argument("--only", default="", help="regular expression of targets")
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"), help="folder of findings and counts")
    parser.add_argument("--case", type=Path, help="run one finding again")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, object_store():
        bench = Bench(Path(folder))
        if chosen.case:
            import_module("torch")  # needs more address space than is left to a trial
            outcome = bench.run(load(chosen.case))
            sys.stdout.write(f"{outcome}\n{outcome.text}\n{outcome.faults}\n")
            return int(bool(outcome.faults))
        counts = fuzz(
            bench, chosen.seed, minutes=chosen.minutes, most=chosen.most, only=chosen.only, out=chosen.out
        )
    write(counts, chosen.out)
    sys.stdout.write(json.dumps(counts, indent=1) + "\n")
    return int(bool(counts["findings"]))


if __name__ == "__main__":
    sys.exit(main())
