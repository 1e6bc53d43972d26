import numpy as np
import pytest
from laboratory_files import tone

from tactogram.errors import DataError, Message, ParameterError, Remedy
from tactogram.signal import Signal
from tactogram_studio.kit import in_fields
from tactogram_studio.pages.materials.drop import (
    LABELS,
    matching_stream,
    mixing_warning,
    store_signal,
)


def test_a_table_without_a_rate_is_stored_and_nonsense_is_not(tmp_path):
    table = b"x,y,z\n1,2,3\n2,3,4\n3,4,5\n"
    assert store_signal(tmp_path, "../my file.csv", table).name == "my_file.csv"
    assert store_signal(tmp_path, "my file.csv", table).name == "my_file-2.csv"
    with pytest.raises((DataError, ParameterError), match="bad.csv"):
        store_signal(tmp_path, "bad.csv", b"no,numbers\nhere,at all\n")
    with pytest.raises(DataError, match="content does not match the suffix"):
        store_signal(tmp_path, "bad.wav", b"MZ nothing")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["my_file-2.csv", "my_file.csv"]


def test_mixing_measured_and_simulated_recordings_gives_a_warning(tones):
    assert mixing_warning(False, False, False) == ""
    assert mixing_warning(True, True, True) == ""
    assert mixing_warning(True, False, True) == ""
    assert "marked as simulated, permanently" in mixing_warning(False, False, True)
    assert "stay marked as simulated" in mixing_warning(True, True, False)
    assert matching_stream(tones, tone(50)) == "acceleration"
    assert matching_stream(tones, Signal(np.ones(5), 10.0, "N")) == ""


def test_remedies_are_the_fields_of_the_page():
    known = Message("no rate", Remedy("give it, e.g.", "rate", 1000), Remedy("omit", "unit"), place="a.csv")
    assert in_fields(known, LABELS) == "a.csv: no rate; give it, e.g. “Rate, Hz”: 1000, or omit “Unit”"
    other = Message("no labels", Remedy("omit the column,", "mapping", "FILE.toml"))
    assert in_fields(other, LABELS) == other == "no labels; omit the column, `mapping=FILE.toml`"
    assert in_fields("a plain text", LABELS) == "a plain text"
