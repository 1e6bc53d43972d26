"""Worker processes import the chores by their own name, from this folder."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))


@pytest.fixture(autouse=True, scope="session")
def importable():
    """Give the folder to processes that do not inherit this one's path."""
    patch = pytest.MonkeyPatch()
    patch.setenv(
        "PYTHONPATH",
        os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH"), str(Path(__file__).parent)])),
    )
    yield
    patch.undo()


DRIVER = """
import sys
from pathlib import Path
import worker_chores as chores
from tactogram.workflows.workers.tasks import kept_values

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    tasks = [(str(folder / "traces"), n) for n in range(6)]
    files = [folder / f"{n}.json" for n in range(6)]
    kept_values(chores.counted, tasks, files, title="squares", on=sys.argv[2], processes=2)
"""


def killed_and_started_again(folder, on):
    """Return the traces of a driver that is killed once two of six tasks are done, and of the one after it."""
    (folder / "traces").mkdir()
    (folder / "driver.py").write_text(DRIVER)
    command = [sys.executable, str(folder / "driver.py"), str(folder), on]
    with subprocess.Popen(command) as driver:
        while len(list(folder.glob("*.json"))) < 2:
            assert driver.poll() is None
            time.sleep(0.05)
        driver.kill()
    done = {file.stem for file in folder.glob("*.json")}
    before = {file.name for file in (folder / "traces").iterdir()}
    subprocess.run(command, check=True)
    again = {file.name for file in (folder / "traces").iterdir()} - before
    return done, {name.partition(".")[0] for name in again}


@pytest.fixture(name="killed_and_started_again")
def killed_and_started_again_fixture():
    return killed_and_started_again
