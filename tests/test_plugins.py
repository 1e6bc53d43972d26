"""Modules of one kind: built-in ones, files in further folders, and what cannot be imported."""

import sys
from dataclasses import dataclass

import pytest

from tactogram.errors import ParameterError
from tactogram.plugins import PluginGroup, further_folders, import_path, import_plugin, module_files

GROUP = PluginGroup("colour", "json", "tactogram.test_colours", "TACTOGRAM_TEST_COLOURS")
"""The built-in ones are the modules of a package of the standard library."""


@dataclass(frozen=True)
class Colour:
    name: str


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("TACTOGRAM_TEST_COLOURS", str(tmp_path))
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_names_are_those_of_the_package_and_of_further_files(folder):
    (folder / "ochre_colour.py").write_text("raise RuntimeError('imported')")
    (folder / "_private.py").write_text("")
    (folder / "umber_colour").mkdir()
    (folder / "umber_colour/__init__.py").write_text("")
    names = GROUP.names()
    assert {"decoder", "encoder", "ochre_colour", "umber_colour"} <= set(names)
    assert "_private" not in names
    assert list(names) == sorted(names)
    assert "ochre_colour" in GROUP
    assert "mauve" not in GROUP


def test_a_module_is_imported_by_its_name_and_once(folder):
    (folder / "ochre_colour.py").write_text("value = object()")
    module = GROUP.module("ochre_colour")
    assert GROUP.module("ochre_colour") is module
    assert GROUP.module("decoder").__name__ == "json.decoder"
    (folder / "sienna_colour.py").write_text("")
    with pytest.raises(ParameterError, match=r"colour must be one of .*decoder.*ochre_colour.*got 'mauve'"):
        GROUP.module("mauve")


def test_a_module_defines_a_value_of_its_kind_with_its_name(folder):
    module = folder / "ochre_colour.py"
    module.write_text("from types import SimpleNamespace\ncolour = SimpleNamespace(name='ochre_colour')\n")
    with pytest.raises(ParameterError, match="must define colour, a Colour called 'ochre_colour'"):
        GROUP.definition("ochre_colour", "colour", Colour)
    GROUP.module("ochre_colour").colour = Colour("umber_colour")
    with pytest.raises(ParameterError, match="must define colour, a Colour called 'ochre_colour'"):
        GROUP.definition("ochre_colour", "colour", Colour)
    GROUP.module("ochre_colour").colour = Colour("ochre_colour")
    assert GROUP.definition("ochre_colour", "colour", Colour) == Colour("ochre_colour")


def test_two_modules_of_one_name_are_refused(folder):
    (folder / "decoder.py").write_text("")
    with pytest.raises(ParameterError, match=r"two colours are called 'decoder': json.decoder, .*decoder.py"):
        GROUP.names()


def test_a_folder_without_modules_is_refused(folder):
    with pytest.raises(ParameterError, match="must be the file of a colour or a folder of such files"):
        module_files(folder, "colour")


def test_folders_are_separated_as_in_path(monkeypatch, tmp_path):
    monkeypatch.setenv("TACTOGRAM_TEST_COLOURS", f"{tmp_path / 'a'}:{tmp_path / 'b'}:")
    assert further_folders("TACTOGRAM_TEST_COLOURS", ["c"])[:2] == (tmp_path / "a", tmp_path / "b")
    assert [folder.name for folder in further_folders("TACTOGRAM_TEST_COLOURS", ["c"])] == ["a", "b", "c"]


def test_a_module_that_fails_is_one_line_and_not_kept(folder):
    file = folder / "ochre_colour.py"
    file.write_text("1 / 0")
    with pytest.raises(ParameterError, match="ochre_colour.py: cannot be imported: ZeroDivisionError"):
        import_plugin(file)
    assert "ochre_colour" not in sys.modules


def test_the_name_of_another_module_is_refused(folder):
    (folder / "json.py").write_text("")
    with pytest.raises(ParameterError, match="rename it, 'json' is the name of another module"):
        import_path(folder / "json.py")
