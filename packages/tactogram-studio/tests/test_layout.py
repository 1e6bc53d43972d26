import ast
import logging
import re
from pathlib import Path

import pytest
from nicegui.props import Props

from tactogram.errors import DataError, ParameterError
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


def test_no_text_is_put_into_properties_unquoted():
    """NiceGUI executes the value of a property that begins with a colon: a text must not end its own."""
    folder = Path(layout.__file__).parent
    wrong = []
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "props" and node.args:
                strings = [part for part in ast.walk(node.args[0]) if isinstance(part, ast.JoinedStr)]
                parts = (
                    [part for part in strings[0].values if isinstance(part, ast.FormattedValue)]
                    if strings
                    else []
                )
                texts = [ast.unparse(part.value) for part in parts]
                allowed = re.compile(r"(kit\.)?attribute\(.*\)|[A-Z_]+", re.DOTALL)
                wrong += [f"{path.name}: {text}" for text in texts if not allowed.fullmatch(text)]
    assert wrong == []


@pytest.mark.parametrize(
    "text", ['a" :title="x', "a' b", "a\\", "\\\" :x='1'", "a\nb\tc", "é🙂\u202e", "`${x}`"]
)
def test_a_text_in_a_property_is_that_text(text):
    assert Props.parse(f'alt="{layout.attribute(text)}" dense') == {"alt": text, "dense": True}


def test_an_answer_does_not_tell_where_the_workspace_is(tmp_path):
    errors = {
        DataError(tmp_path / "tones", "no recording 'x'"): "tones: no recording 'x'",
        ParameterError(f"no store in {tmp_path}"): "no store in .",
        FileNotFoundError(2, "No such file or directory", tmp_path / "x.wav"): "No such file or directory",
    }
    assert [layout.without_folder(error, tmp_path) for error in errors] == list(errors.values())
