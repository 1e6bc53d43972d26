"""Kills and a full disk at some commit points of each command; `tests/fuzz/kills.py` draws more, nightly."""

import subprocess
import sys
from pathlib import Path

import pytest

KILLS = Path(__file__).with_name("kills.py")


@pytest.mark.slow
@pytest.mark.parametrize("options", [[], ["--full"]], ids=["killed", "full-disk"])
def test_what_is_stopped_anywhere_leaves_the_old_state_or_the_new_and_can_be_repeated(options):
    command = [
        sys.executable,
        KILLS,
        "--minutes",
        "0.5",
        *options,
        "--only",
        "import",
        "add",
        "simulate",
        "train",
    ]
    done = subprocess.run([*command, "generate --conditions"], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
