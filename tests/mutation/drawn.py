"""Mutation check of the whole core: seeded mutants of one token each, of which the tests must kill a share.

``python tests/mutation/drawn.py [--count N] [--seed S] [--floor SHARE] [WORD…]`` draws N places among all tokens of
`src/tactogram` that can be swapped (comparisons, arithmetic, and/or, min/max, True/False, whole numbers), in files
whose path has one of the words if any. Each mutant faces the tests that stand at its module's path and those that
import it. A mutant that changes nothing anyone can see also survives, so the floor is below 1.
"""

from __future__ import annotations

import argparse
import ast
import io
import random
import subprocess
import sys
import tempfile
import tokenize
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from run import FAILED, PROCESSES, ROOT, copy_sources, run_tests

SWAPS = {
    **{"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    **{"+": "-", "-": "+", "*": "/", "/": "*", "//": "/", "%": "*", "+=": "-=", "-=": "+="},
    **{"and": "or", "or": "and", "min": "max", "max": "min", "True": "False", "False": "True"},
    **{"any": "all", "all": "any"},
}
FLOOR = 0.4
"""Of 60 drawn with seed 1, 32 are killed; the share of as many drawn anew scatters by 0.13 (two deviations)."""
MOST_TESTS = 4
"""Test files that a mutant faces, those at its module's path first."""


@dataclass(frozen=True)
class Mutant:
    """One token of a file, and what it becomes."""

    file: str
    line: int
    column: int
    token: str
    instead: str

    def apply(self, source: str) -> str:
        """Return the source with the token swapped."""
        lines = source.splitlines(keepends=True)
        line = lines[self.line - 1]
        lines[self.line - 1] = line[: self.column] + self.instead + line[self.column + len(self.token) :]
        return "".join(lines)

    def __str__(self) -> str:
        return f"{self.file.removeprefix('src/tactogram/')}:{self.line}: {self.token} -> {self.instead}"


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Yield every mutant of a file: not in annotations, imports, error messages and what else nobody computes with."""
    source = path.read_text(encoding="utf-8")
    spared = _spared(ast.parse(source))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        line, column = token.start
        if (line, column) in spared:
            continue
        instead = SWAPS.get(token.string)
        if token.type == tokenize.NUMBER and token.string.isdecimal():
            instead = str(int(token.string) + 1)
        if instead is not None:
            yield Mutant(path.relative_to(ROOT).as_posix(), line, column, token.string, instead)


def _spared(tree: ast.AST) -> set[tuple[int, int]]:
    """Return the places of annotations, imports and texts with values, and of what is raised."""
    places: set[tuple[int, int]] = set()
    for node in ast.walk(tree):
        dropped: list[ast.expr | ast.stmt | None] = []
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            dropped = [node.returns, *(one.annotation for one in arguments)]
        elif isinstance(node, ast.AnnAssign):
            dropped = [node.annotation]
        elif isinstance(node, ast.Raise | ast.Import | ast.ImportFrom | ast.JoinedStr):
            dropped = [node]
        for each in dropped:
            if each is not None:
                first, end = (each.lineno, each.col_offset), (each.end_lineno or 0, each.end_col_offset or 0)
                places |= {
                    (line, column)
                    for line in range(first[0], end[0] + 1)
                    for column in range(
                        first[1] if line == first[0] else 0, end[1] if line == end[0] else 200
                    )
                }
    return places


def tests_of(file: str, imports: dict[Path, str]) -> list[str]:
    """Return the test files of a module: at its path, then the shortest of those that import it."""
    path = Path(file)
    inner = path.relative_to("src/tactogram")
    at_path = [
        Path("tests") / inner.parent / f"test_{path.stem}.py",
        path.parent / "tests" / f"test_{path.stem}.py",
    ]
    module = ".".join(path.with_suffix("").parts[1:])
    importing = sorted((len(text), test) for test, text in imports.items() if module in text)
    found = [test for test in at_path if (ROOT / test).exists()]
    found += [test for _, test in importing if test not in found]
    return [test.as_posix() for test in found[:MOST_TESTS]]


def verdict(folder: Path, mutant: Mutant, tests: list[str]) -> str:
    """Return what became of a mutant; ``folder`` is left as it was."""
    if not tests:
        return "NO TEST"
    file = folder / mutant.file
    source = file.read_text(encoding="utf-8")
    file.write_text(mutant.apply(source), encoding="utf-8")
    try:
        done = run_tests(folder, ["-m", "not slow", *tests], keep_bytecode=False)
    except subprocess.TimeoutExpired:  # a test that hangs noticed it, too
        return "killed"
    finally:
        file.write_text(source, encoding="utf-8")
    return "SURVIVED" if done.returncode == 0 else "killed" if done.returncode in (FAILED, 2) else "NO TEST"


def main() -> int:
    """Draw mutants, try them two at a time, and print what became of each; 1 if fewer than the floor are killed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--floor", type=float, default=FLOOR)
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    files = sorted(path for path in (ROOT / "src").rglob("*.py") if "tests" not in path.parts)
    chosen = [path for path in files if not options.words or any(word in str(path) for word in options.words)]
    every = [mutant for path in chosen for mutant in mutants_of(path)]
    drawn = random.Random(options.seed).sample(every, min(options.count, len(every)))
    imports = {
        path.relative_to(ROOT): path.read_text(encoding="utf-8")
        for folder in ("tests", "src")
        for path in (ROOT / folder).rglob("test_*.py")
    }
    with tempfile.TemporaryDirectory(prefix="mutants-") as scratch:
        folders: SimpleQueue[Path] = SimpleQueue()
        for number in range(PROCESSES):
            copy_sources(folder := Path(scratch) / str(number))
            folders.put(folder)

        def tried(mutant: Mutant) -> str:
            folder = folders.get()
            try:
                return verdict(folder, mutant, tests_of(mutant.file, imports))
            finally:
                folders.put(folder)

        found = []
        with ThreadPoolExecutor(PROCESSES) as pool:
            for mutant, became in zip(drawn, pool.map(tried, drawn), strict=True):
                found.append(became)
                print(f"{became:8}  {mutant}", flush=True)
    killed = found.count("killed")
    print(f"{killed} of {len(found)} mutants killed, of {len(every)} possible; floor {options.floor:.0%}")
    return 0 if killed >= options.floor * len(found) else 1


if __name__ == "__main__":
    sys.exit(main())
