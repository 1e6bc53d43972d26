"""Mutation check: each defect of `mutants.toml`, put into a copy of the sources, must fail the tests it names.

``python tests/mutation/run.py`` tries all; ``python tests/mutation/run.py frictgan critic`` those whose file or title
has one of the words. The status is 1 if a mutant survives, no longer applies or breaks the tests otherwise.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from time import monotonic
from typing import Any

ROOT = Path(__file__).parents[2]
LIST = Path(__file__).with_name("mutants.toml")
COPIED = ("src", "packages", "tests", "conftest.py", "pyproject.toml")
PROCESSES = 2
LONGEST_S = 600
"""A mutant's tests take some seconds, on a busy machine a minute; one that hangs is reported."""
FAILED = 1
"""pytest's status when tests failed; any other but 0 means that they did not run."""


def mutants(words: list[str]) -> list[dict[str, Any]]:
    """Return the mutants whose file or title has one of ``words``; all without any."""
    every: list[dict[str, Any]] = tomllib.loads(LIST.read_text(encoding="utf-8"))["mutant"]
    return [m for m in every if not words or any(word in m["file"] + m["title"] for word in words)]


def copy_sources(folder: Path) -> None:
    """Copy into ``folder`` what tests need."""
    folder.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(source, folder / name)


def run_tests(folder: Path, tests: list[str], *, keep_bytecode: bool) -> subprocess.CompletedProcess[str]:
    """Run ``tests`` on the sources in ``folder`` until one fails."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(map(str, [folder / "src", *folder.glob("packages/*/src")])),
        "OMP_NUM_THREADS": "1",
    }
    # The plugins take longer to load than most of the tests to run.
    environment |= {
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONDONTWRITEBYTECODE": "" if keep_bytecode else "1",
    }
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider", *tests]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST_S, check=False
    )


def verdict(folder: Path, mutant: dict[str, Any]) -> str:
    """Return "killed", or what else became of a mutant; ``folder`` is left as it was."""
    file = folder / mutant["file"]
    source = file.read_text(encoding="utf-8") if file.is_file() else ""
    if source.count(mutant["text"]) != 1:
        return f"does not apply: its text occurs {source.count(mutant['text'])} times"
    file.write_text(source.replace(mutant["text"], mutant["instead"]), encoding="utf-8")
    try:
        done = run_tests(folder, mutant["tests"], keep_bytecode=False)
    except subprocess.TimeoutExpired:
        return f"hung for {LONGEST_S} s"
    finally:
        file.write_text(source, encoding="utf-8")
    if done.returncode == FAILED:
        return "killed"
    if done.returncode == 0:
        return "SURVIVED"
    return f"tests did not run:\n{done.stdout[-2000:]}{done.stderr[-500:]}"


def main(words: list[str]) -> int:
    """Try the mutants, two at a time, and print what became of each."""
    chosen, begun = mutants(words), monotonic()
    if not chosen:
        print(f"no mutant has {' or '.join(words)} in its file or title")
        return 2
    with tempfile.TemporaryDirectory(prefix="mutants-") as scratch:
        first, *others = (Path(scratch) / str(number) for number in range(PROCESSES))
        copy_sources(first)
        plain = run_tests(first, sorted({test for m in chosen for test in m["tests"]}), keep_bytecode=True)
        if plain.returncode:
            print(f"the tests fail without any mutant:\n{plain.stdout[-4000:]}{plain.stderr[-500:]}")
            return 1
        folders: SimpleQueue[Path] = SimpleQueue()
        folders.put(first)
        for other in others:
            folders.put(Path(shutil.copytree(first, other)))

        def tried(mutant: dict[str, Any]) -> str:
            folder = folders.get()
            try:
                return verdict(folder, mutant)
            finally:
                folders.put(folder)

        killed = 0
        with ThreadPoolExecutor(PROCESSES) as pool:
            for mutant, found in zip(chosen, pool.map(tried, chosen), strict=True):
                killed += found == "killed"
                print(
                    f"{found:8}  {mutant['file'].removeprefix('src/tactogram/')}: {mutant['title']}",
                    flush=True,
                )
    print(f"{killed} of {len(chosen)} mutants killed in {monotonic() - begun:.0f} s")
    return 0 if killed == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
