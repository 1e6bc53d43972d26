"""Measure everything, or what is named, and write the table: ``python -m benchmarks [NAME…]``."""

import json
import os
import platform
import sys
from importlib import import_module
from pathlib import Path

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
FOLDER = Path(__file__).parent
HEAD = """# Benchmarks

Written by `make bench` (`python -m benchmarks`). Ratios are taken in one run on one machine; absolute times are for
orientation only. Each table is the last run of its module.
"""


def main(names):
    available = sorted(file.stem.removeprefix("bench_") for file in FOLDER.glob("bench_*.py"))
    unknown = set(names) - set(available)
    if unknown:
        sys.exit(f"benchmarks are {', '.join(available)}; unknown: {', '.join(sorted(unknown))}")
    kept = FOLDER / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {}
    for name in names or available:
        sys.stderr.write(f"{name} …\n")
        module = import_module(f"benchmarks.bench_{name}")
        results[name] = {"about": (module.__doc__ or "").strip(), "machine": machine(), "rows": module.run()}
        kept.write_text(json.dumps(results, indent=1) + "\n")
    (FOLDER / "results.md").write_text(
        HEAD + "".join(section(name, r) for name, r in sorted(results.items()))
    )


def machine():
    return f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"


def section(name, result):
    rows = result["rows"]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    lines += ["| " + " | ".join(cell(row.get(column)) for column in columns) + " |" for row in rows]
    return f"\n## {name}\n\n{result['about']}\n\nMachine: {result['machine']}.\n\n" + "\n".join(lines) + "\n"


def cell(value):
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main(sys.argv[1:])
