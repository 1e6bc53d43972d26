"""How a file is refused."""

import pytest

from tactogram.errors import DataError
from tactogram.signal.io import read_signal
from tactogram.workflows.data.convert import convert


def refusal(path, **options):
    """Return the one line with which ``path`` is refused, and check that convert refuses it and writes nothing."""
    with pytest.raises(DataError) as caught:
        read_signal(path, **options)
    with pytest.raises(DataError):
        convert(path, path.with_name("target") / "b.wav", **options)
    assert not path.with_name("target").exists()
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")
