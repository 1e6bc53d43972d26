"""Scripts with and without a main guard, which processes that start run again."""

import subprocess
import sys

import pytest

CALL = 'import_store("folder", "f", "s"{workers})["recordings"]'
PLAIN = f"print({CALL})"
INNER = f"def main():\n    print({CALL})\n\nmain()"
GUARDED = f'if __name__ == "__main__":\n    print({CALL})'
SIMULATED = 'print(simulate_to_store("stroking9", "s", per_class=1, seconds=0.1{workers})["recordings"])'


@pytest.fixture
def run(tmp_path):
    """Run a script in a folder with six recordings, without waiting for the processes to be worth their start."""
    (tmp_path / "f" / "cork").mkdir(parents=True)
    for number in range(6):
        rows = "".join(f"{k / 100},{number * k % 7}\n" for k in range(50))
        (tmp_path / "f" / "cork" / f"{number}.csv").write_text("t [s],x [g]\n" + rows)

    def run(body, workers):
        start = [
            "from tactogram.datasets import reading",
            "from tactogram_simulate import simulate_to_store",
            "from tactogram.workflows.data.stores import import_store",
            "reading.PATIENCE_S = 0",
            "reading.cores = lambda: 2",
        ]
        (tmp_path / "script.py").write_text("\n".join([*start, body.format(workers=workers)]))
        return subprocess.run(
            [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False
        )

    return run


@pytest.mark.parametrize(
    ("body", "workers"), [(PLAIN, ""), (INNER, ""), (GUARDED, ""), (GUARDED, ", workers=2")]
)
def test_a_script_needs_no_guard_unless_it_asks_for_processes(run, body, workers):
    done = run(body, workers)
    assert (done.stdout.split(), done.stderr) == (["6"], "")


@pytest.mark.parametrize(("body", "line"), [(PLAIN, 6), (INNER, 9), (SIMULATED, 6)])
def test_processes_that_would_run_a_script_again_are_refused(run, tmp_path, body, line):
    said = run(body, ", workers=2").stderr
    assert said.count("Traceback") == 1
    assert said.splitlines()[-1].endswith(
        f"script.py: line {line} must be below `if __name__ == '__main__':` for 2 processes, since each would run it "
        "again; add that, or ask for 1"
    )
    assert not (tmp_path / "s").exists()
