import pytest

from tactogram.datasets.cells import finite_number
from tactogram.errors import DataError


def test_a_cell_is_read_as_a_number():
    assert finite_number("a.csv: row 2", "force", " 1.5e-3 ") == 0.0015


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1,5", "a number, got '1,5'"),
        ("", "a number, got ''"),
        (None, "a number, got ''"),
        (" nan\n", "a finite number, got 'nan'"),
        ("-inf", "a finite number, got '-inf'"),
    ],
)
def test_what_is_no_finite_number_names_its_place(text, told):
    with pytest.raises(DataError) as caught:
        finite_number("a.csv: row 2", "force", text)
    assert str(caught.value) == f"a.csv: row 2: force must be {told}"
