"""Scripts with and without a main guard, which processes that start run again."""

import runpy
import subprocess
import sys

import pytest

from tactogram.datasets import reading
from tactogram.errors import ParameterError

CALL = 'import_store("folder", "f", "s"{workers})["recordings"]'
PLAIN = f"print({CALL})"
INNER = f"def main():\n    print({CALL})\n\nmain()"
GUARDED = f'if __name__ == "__main__":\n    print({CALL})'
SIMULATED = 'print(simulate_to_store("stroking9", "s", per_class=1, seconds=0.1{workers})["recordings"])'
NUMBER = 'if __name__ == "__main__":\n    print(allowed_processes(None, 2))'


@pytest.fixture
def script(tmp_path, monkeypatch):
    """Write a script to a folder with six recordings, without waiting for the processes to be worth their start."""
    (tmp_path / "f" / "cork").mkdir(parents=True)
    for number in range(6):
        rows = "".join(f"{k / 100},{number * k % 7}\n" for k in range(50))
        (tmp_path / "f" / "cork" / f"{number}.csv").write_text("t [s],x [g]\n" + rows)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reading, "PATIENCE_S", reading.PATIENCE_S)  # the script changes both
    monkeypatch.setattr(reading, "cores", reading.cores)

    def write(body, workers):
        start = [
            "from tactogram.datasets import reading",
            "from tactogram.main_script import allowed_processes",
            "from tactogram_simulate import simulate_to_store",
            "from tactogram.workflows.data.stores import import_store",
            "reading.PATIENCE_S = 0",
            "reading.cores = lambda: 2",
        ]
        (tmp_path / "script.py").write_text("\n".join([*start, body.format(workers=workers)]))
        return "script.py"

    return write


def run(script):
    return subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("body", "workers"), [(PLAIN, ""), (GUARDED, ", workers=2")])
def test_a_script_needs_no_guard_unless_it_asks_for_processes(script, body, workers):
    done = run(script(body, workers))
    assert (done.stdout.split(), done.stderr) == (["6"], "")


@pytest.mark.parametrize(("body", "said"), [(INNER, "6"), (NUMBER, "2")])
def test_several_processes_are_the_default_only_below_a_guard(script, capsys, body, said):
    runpy.run_path(script(body, ""), run_name="__main__")
    assert capsys.readouterr().out.split() == [said]


def refusal(line):
    return (
        f"script.py: line {line} must be below `if __name__ == '__main__':` for 2 processes, since each would run it "
        "again; add that, or ask for 1"
    )


def test_a_refusal_ends_the_script_in_one_traceback(script, tmp_path):
    said = run(script(PLAIN, ", workers=2")).stderr
    assert said.count("Traceback") == 1
    assert said.splitlines()[-1].endswith(refusal(7))
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(("body", "line"), [(INNER, 10), (SIMULATED, 7)])
def test_processes_that_would_run_a_script_again_are_refused(script, tmp_path, body, line):
    with pytest.raises(ParameterError) as refused:
        runpy.run_path(script(body, ", workers=2"), run_name="__main__")
    assert str(refused.value) == refusal(line)
    assert not (tmp_path / "s").exists()
