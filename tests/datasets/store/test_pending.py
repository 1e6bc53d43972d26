"""Parts of imports that run, and those of killed ones."""

import os

from tactogram.datasets.store.pending import clear_stale_parts


def test_parts_of_running_imports_are_named_and_left(tmp_path):
    own = tmp_path / f"s.part-elsewhere-{os.getpid()}"
    own.mkdir()
    assert clear_stale_parts(tmp_path / "s") == [own]
    assert own.exists()
