"""Table of what the reader makes of each case: ``python tests/signal/io/foreign [part of a name]``."""

import importlib
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[4]
sys.path.insert(0, str(ROOT))
tests = importlib.import_module("tests")
tests.__path__ = [str(ROOT / "tests"), *tests.__path__]  # a library installs a package of this name, too
foreign = importlib.import_module("tests.signal.io.foreign")

wanted = sys.argv[1] if len(sys.argv) > 1 else ""
counts: Counter[str] = Counter()
for example in foreign.CASES:
    if wanted not in example.name:
        continue
    with tempfile.TemporaryDirectory() as folder:
        try:
            verdict = foreign.check(example, Path(folder))
            word, good, differs = verdict.word, verdict.good, verdict.differs
        except Exception as error:  # a traceback of the reader is a line of the table
            word, good, differs = "CRASH", False, f"{type(error).__name__}: {error}"
    counts[f"{word}{'' if good else ' (not good)'}"] += 1
    sys.stdout.write(f"{'ok' if good else '--':3}{example.name:34}{word:9}{differs}\n")
sys.stdout.write(", ".join(f"{count} {word}" for word, count in counts.most_common()) + "\n")
