"""The table of losses of haptic files."""

import pytest

from tactogram_studio.workspace.file_losses import loss_text, losses_table

LOSS = {"envelope_correlation": 0.98765, "waveform_correlation": 0.5, "snr_db": 12.4, "level_db": -0.0001}


def test_each_axis_of_a_format_is_a_row_and_a_refusal_is_told():
    files = {
        "ahap": {"written": {"bytes": 100, "loss": LOSS}},
        "hjif": {"written": {"bytes": 300, "loss": {"x": LOSS, "y": LOSS}}},
        "android": {"refused": "too long"},
    }
    rows = losses_table(files)
    assert [(row["format"], row["axis"]) for row in rows] == [
        ("ahap", ""),
        ("hjif", "x"),
        ("hjif", "y"),
        ("android", ""),
    ]
    assert rows[0]["bytes"] == 100
    assert rows[2]["snr_db"] == 12.4
    assert rows[3]["refused"] == "too long"


@pytest.mark.parametrize(
    ("name", "key", "text"),
    [
        ("hjif", "snr_db", "12"),
        ("hjif", "envelope_correlation", "0.988"),
        ("hjif", "level_db", "0.000"),
        ("ahap", "snr_db", "none"),
        ("ahap", "waveform_correlation", "none"),
    ],
)
def test_a_file_without_a_waveform_has_no_error_of_one(name, key, text):
    assert loss_text({"format": name} | LOSS, key) == text


def test_a_loss_that_is_not_known_is_none():
    assert loss_text({"format": "hjif", "level_db": None}, "level_db") == "none"
