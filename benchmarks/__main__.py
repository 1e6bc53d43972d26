"""Benchmarks of speed, and experiments that no publication has: ``python -m benchmarks [NAME…]``.

Without a name, tactogram is compared with what one would take without it (``comparison``), in some five minutes. Names
of speed benchmarks, or ``all``, are measured into results.md. The name of an experiment runs that one.
"""

import argparse
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
orientation only. Each table is the last run of its module. The first one is what `make bench` prints.
"""


def main(arguments=None):
    """Run what the arguments name; return the exit status."""
    from tactogram.cli.printing import Printer, columns
    from tactogram.errors import TactogramError
    from tactogram.recipe import parse_changes
    from tactogram.workflows.progress import shown
    from tactogram_benchmark.experiments.catalogue import experiments, reproduce

    parser = parser_of_options()
    a = parser.parse_args(arguments)
    show = Printer(json=a.json)
    ours = experiments(FOLDER / "experiments")
    speed = sorted(file.stem.removeprefix("bench_") for file in FOLDER.glob("bench_*.py"))
    if a.list:
        show(ours, columns(list(ours.items())) + f"\nspeed: {', '.join(speed)}")
        return 0
    if unknown := set(a.names) - {*ours, *speed, "all"}:
        parser.error(f"unknown: {', '.join(sorted(unknown))}; see --list")
    if not ours.keys() & set(a.names):
        if a.set or a.out or a.recipe:
            parser.error("--recipe, --set and --out are those of experiments; see --list")
        names = speed if "all" in a.names else a.names or ["comparison"]
        measure(names)
        return 0
    if len(a.names) > 1:
        parser.error("an experiment runs alone: give one name")
    try:
        with shown() as progress:
            result = reproduce(
                a.names[0],
                recipe=a.recipe or "bench",
                out=a.out,
                options=parse_changes(a.set),
                package="benchmarks.experiments",
                progress=progress,
            )
    except TactogramError as error:
        sys.stderr.write(f"benchmarks: {error}\n")
        return 1
    show(result, result["text"])
    return 0


def parser_of_options():
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.split("\n", 1)[0])
    parser.add_argument("names", metavar="NAME", nargs="*")
    parser.add_argument("--list", action="store_true", help="list the experiments and the speed benchmarks")
    parser.add_argument("--recipe", help="of an experiment: bench (two cores, the default) or paper (whole)")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="an experiment's option, e.g. seeds=200",
    )
    parser.add_argument("--out", metavar="DIR", help="folder for an experiment's results (default runs/NAME)")
    parser.add_argument("--json", action="store_true", help="print an experiment's result as JSON")
    return parser


def measure(names):
    """Take the named measurements, keep them in results.json and write the table."""
    kept = FOLDER / "results.json"
    results = json.loads(kept.read_text()) if kept.exists() else {}
    for name in names:
        sys.stderr.write(f"{name} …\n")
        module = import_module(f"benchmarks.bench_{name}")
        results[name] = {"about": (module.__doc__ or "").strip(), "machine": machine(), "rows": module.run()}
        kept.write_text(json.dumps(results, indent=1) + "\n")
        print(section(name, results[name]))
    names = sorted(results, key=lambda name: (name != "comparison", name))
    (FOLDER / "results.md").write_text(HEAD + "".join(section(name, results[name]) for name in names))


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
    sys.exit(main())
