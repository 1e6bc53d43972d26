import logging
from pathlib import Path

from tactogram.errors import ParameterError
from tactogram_studio import layout


def test_an_error_after_its_page_is_closed_is_logged(caplog, monkeypatch):
    def gone(*_, **__):
        raise RuntimeError("The parent element this slot belongs to has been deleted.")  # NiceGUI's

    monkeypatch.setattr(layout.ui, "notify", gone)
    with caplog.at_level(logging.WARNING):
        layout.show_error(ParameterError("expected a, got b"))
    assert [record.getMessage() for record in caplog.records] == [
        "page closed before this error could be shown: expected a, got b"
    ]


def test_a_page_may_take_long_on_its_first_visit():
    assert layout.route("/slow").response_timeout >= 60
    pages = (Path(layout.__file__).parent / "pages").rglob("*.py")
    assert [file for file in pages if "ui.page(" in file.read_text(encoding="utf-8")] == []
