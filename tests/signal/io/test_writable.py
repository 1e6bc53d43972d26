from pathlib import Path

import pytest

from tactogram.errors import ParameterError
from tactogram.signal.io.writable import check_writable


@pytest.mark.parametrize("folder", [True, False])
def test_a_place_that_can_be_written_is_left_as_it_was(folder, tmp_path):
    check_writable(tmp_path / "a" / "b", folder=folder)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_may_be_replaced(tmp_path):
    (tmp_path / "made.wav").write_bytes(b"before")
    check_writable(tmp_path / "made.wav")
    assert (tmp_path / "made.wav").read_bytes() == b"before"


@pytest.mark.parametrize("folder", [True, False])
@pytest.mark.parametrize("place", [__file__, "/proc"])
def test_a_place_that_takes_no_file_is_refused_with_the_reason(place, folder):
    if not Path(place).exists():
        pytest.skip("this system has no /proc")
    with pytest.raises(ParameterError, match=r"made: cannot be written \(.+\); give another place"):
        check_writable(Path(place) / "made", folder=folder)


def test_a_file_in_a_folders_place_is_refused_and_the_other_way_round(tmp_path):
    with pytest.raises(ParameterError, match="is a file; a folder is needed"):
        check_writable(Path(__file__), folder=True)
    with pytest.raises(ParameterError, match="is a folder; a file is needed"):
        check_writable(tmp_path)
