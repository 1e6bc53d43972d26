import logging
from pathlib import Path

import pytest

from tactogram.errors import ParameterError
from tactogram_studio import layout
from tactogram_studio.kit import attribute, in_range


def test_an_error_after_its_page_is_closed_is_logged(caplog, monkeypatch):
    def gone(*_, **__):
        raise RuntimeError("The parent element this slot belongs to has been deleted.")  # NiceGUI's

    monkeypatch.setattr(layout.ui, "notify", gone)
    with caplog.at_level(logging.WARNING):
        layout.show_error(ParameterError("expected a, got b"))
    assert [record.getMessage() for record in caplog.records] == [
        "page closed before this error could be shown: expected a, got b"
    ]


@pytest.mark.parametrize(
    ("value", "bounds", "message"),
    [
        (-3.0, {"least": 0.1}, "Seconds must be at least 0.1, got -3"),
        (12.0, {"least": 0, "most": 9}, "Seconds must be 0 to 9, got 12"),
        (2.5, {"whole": True}, "Seconds must be a whole number, got 2.5"),
        (float("nan"), {"least": 0}, "Seconds must be at least 0, got nan"),
    ],
)
def test_a_number_out_of_range_is_refused_and_not_altered(value, bounds, message):
    with pytest.raises(ParameterError, match=f"^{message}$"):
        in_range("Seconds", value, **bounds)
    assert in_range("Seconds", 1.0, **bounds) == 1.0
    assert in_range("Seconds", None, **bounds) is None


def test_an_attribute_keeps_no_quotes_backslashes_or_line_breaks():
    assert attribute('rubber "soft"\nC:\\x') == "rubber 'soft' C:/x"


def test_a_page_may_take_long_on_its_first_visit():
    assert layout.route("/slow").response_timeout >= 60
    pages = (Path(layout.__file__).parent / "pages").rglob("*.py")
    assert [file for file in pages if "ui.page(" in file.read_text(encoding="utf-8")] == []
