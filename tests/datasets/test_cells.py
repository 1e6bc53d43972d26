import pytest

from tactogram.datasets.cells import finite_number
from tactogram.errors import DataError


def test_a_cell_is_read_as_a_number():
    assert finite_number("a.csv: row 2", "force", " 1.5e-3 ") == 0.0015


@pytest.mark.parametrize("text", ["", None, "1,5", "nan", "inf", "three"])
def test_what_is_no_finite_number_names_its_place(text):
    with pytest.raises(DataError, match=r"a\.csv: row 2: force must be a number, got "):
        finite_number("a.csv: row 2", "force", text)
