"""Extensions: a new one of a kind is one file, and no shared file names a built-in one."""

import ast
import json
import re
import shlex
import sys
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.datasets.importer import IMPORTERS
from tactogram.evaluation.measures.measure import MEASURES
from tactogram.plugins import PluginGroup
from tactogram.rendering.displays.catalogue import FAMILIES, open_display
from tactogram.rendering.files.catalogue import FORMATS, haptic_formats
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram_capture.catalogue import SOURCES
from tactogram_playback.streaming.output import DisplayOutput
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.sent import DriveRequest, FileRequest, SendService
from tactogram_studio.workspace.shelf import ResultArchive

ROOT = Path(__file__).parents[1]
SOURCES_OF_PACKAGES = (ROOT / "src", *sorted((ROOT / "packages").glob("*/src")))
ROOMS = (
    "rendering",
    "workflows/data",
    "workflows/rendering",
    "tactogram_playback",
    "tactogram_studio/pages/send",
    "cli",
)


@dataclass(frozen=True)
class Kind:
    """A kind of extension: its group, its recipe in docs, and the folders where its names mean nothing else."""

    group: PluginGroup
    recipe: str
    rooms: tuple[str, ...]
    words: tuple[str, ...] = ()
    """Names that are common words: only their imports count."""

    @property
    def folder(self):
        return Path(import_module(self.group.package).__file__).parent


KINDS = {
    "haptic format": Kind(FORMATS, "haptic format", ROOMS),
    "display family": Kind(FAMILIES, "display family", ROOMS),
    "importer": Kind(IMPORTERS, "importer", ("datasets", "workflows/data")),
    "measure": Kind(MEASURES, "measure", ("evaluation/generation", "workflows/evaluation/generator", "cli")),
    "capture source": Kind(
        SOURCES,
        "capture source",
        ("tactogram_capture", "tactogram_studio/pages/live"),
        ("simulated", "log"),
    ),
}
OTHER_MEANINGS = {
    ("haptic format", "rendering/families/ultrasonic.py", "vibration"): "a mapping of its signal",
    ("haptic format", "rendering/displays/catalogue.py", "vibration"): "what a display renders",
    ("haptic format", "rendering/files/loss.py", "vibration"): "a kind of event",
    ("display family", "rendering/files/formats/vibration.py", "pattern"): "a key of its documents",
    ("importer", "tactogram_studio/pages/materials/columns.py", "folder"): "what names a material",
    (
        "importer",
        "tactogram_studio/pages/materials/import_page.py",
        "folder",
    ): "what names a material, and a part of its page",
    ("capture source", "tactogram_capture/logs.py", "serial"): "a kind of log",
    ("capture source", "tactogram_capture/logs.py", "twelite"): "a kind of log",
    ("capture source", "tactogram_capture/stream/csv_source.py", "serial"): "a kind of log",
    ("capture source", "tactogram_capture/twelite/source.py", "twelite"): "a kind of log",
    ("capture source", "tactogram_capture/twelite/simulator.py", "twelite"): "a kind of log",
    ("capture source", "tactogram_capture/workflows/logs.py", "serial"): "a kind of log",
    ("capture source", "tactogram_capture/workflows/logs.py", "twelite"): "a kind of log",
    ("capture source", "tactogram_capture/stream/byte_source.py", "serial"): "a library",
    ("capture source", "tactogram_capture/logs.py", "lsl"): "an extra",
} | {("measure", "evaluation/measures/__init__.py", name): "the function alone" for name in MEASURES.names()}
OTHER_MEANINGS |= {
    ("capture source", "tactogram_capture/workflows/devices.py", name): "the tests of devices"
    for name in SOURCES.names()
}


@lru_cache(maxsize=1)
def source_names():
    """Return the imported names and the strings of every source file, by its path."""
    found = {}
    for path in (path for folder in SOURCES_OF_PACKAGES for path in folder.rglob("*.py")):
        imports, strings = found.setdefault(path, (set(), set()))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                imports.update(f"{node.module}.{alias.name}." for alias in node.names)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                strings.add(node.value)
    return found


def naming(kind, name):
    """Yield the shared source files that import a built-in module of a kind, or hold its name as a string."""
    module = f"{kind.group.package}.{name}."
    for path, (imports, strings) in source_names().items():
        folder = next(folder for folder in SOURCES_OF_PACKAGES if path.is_relative_to(folder))
        place = path.relative_to(folder).as_posix().removeprefix("tactogram/")
        named = place.startswith(kind.rooms) and name not in kind.words and name in strings
        imported = any(each.startswith(module) for each in imports)
        if (named or imported) and not path.is_relative_to(kind.folder):
            yield place


@pytest.mark.parametrize("kind", KINDS)
def test_no_shared_file_names_a_built_in_one(kind):
    names = KINDS[kind].group.names()
    assert len(names) > 3
    found = {(kind, place, name) for name in names for place in naming(KINDS[kind], name)}
    assert found <= set(OTHER_MEANINGS)


@pytest.fixture(name="recipe")
def recipe_fixture(request, tmp_path, monkeypatch):
    """Write the files of a recipe in docs/extend*.md; give its Python files and its commands."""
    kind = KINDS[request.param]
    text = "".join(page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").glob("extend*.md")))
    block = re.search(rf"<!-- {kind.recipe} -->\n(.*?)<!-- /{kind.recipe} -->", text, re.DOTALL)[1]
    *files, (_, commands) = re.findall(r"```(\w+)\n(.*?)```", block, re.DOTALL)
    modules = []
    for language, content in files:
        path = tmp_path / re.match(r"# (\S+)\n", content)[1]
        path.parent.mkdir(exist_ok=True)
        path.write_text(content, encoding="utf-8")
        modules += [path] if language == "python" else []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(kind.group.variable, "mine")
    yield modules, [shlex.split(line)[1:] for line in commands.splitlines()]
    for path in modules:
        sys.modules.pop(path.stem, None)


@pytest.fixture(name="touch")
def touch_fixture(tmp_path):
    """Give a signal of half a second, written as touch.wav."""
    t = np.arange(500) / 1000
    signal = Signal(2 * np.sin(2 * np.pi * 50 * t) * (t > 0.25), 1000, "m/s^2")
    write_signal(tmp_path / "touch.wav", signal)
    return signal


def sending(folder):
    workspace = Workspace.at(folder)
    return SendService(workspace, ResultArchive(workspace.studio_folder / "kept"))


@pytest.mark.parametrize("recipe", ["haptic format"], indirect=True)
def test_a_haptic_format_is_one_file(recipe, touch, tmp_path, capsys):
    modules, commands = recipe
    assert len(modules) == 1
    assert [main(command) for command in commands] == [0, 0, 0]
    assert "Taps, 0 to 9" in capsys.readouterr().out
    assert main(["convert", "touch.taps", "back.wav"]) == 0
    back = read_signal(tmp_path / "back.wav").samples[0]
    halves = [np.sqrt(np.mean(half**2)) for half in (back[:1900], back[2100:])]
    assert halves == pytest.approx([0, np.sqrt(2)], rel=0.06)
    page = sending(tmp_path)
    assert haptic_formats()["taps"].title == "Taps, 0 to 9"
    assert page.file(FileRequest("file:touch.wav", "taps")).facts["files"]["taps"]["problems"] == []
    (tmp_path / "wrong.taps").write_text('{"taps": 10}')
    assert main(["convert", "--check", "wrong.taps"]) == 1


@pytest.mark.parametrize("recipe", ["display family"], indirect=True)
def test_a_display_family_is_one_file(recipe, touch, tmp_path, capsys):
    modules, commands = recipe
    assert len(modules) == 1
    assert [main(command) for command in commands] == [0, 0]
    drive = read_signal(tmp_path / "drive.wav")
    assert (drive.samples.min(), drive.samples.max()) == pytest.approx(
        (0.1, 0.9), abs=0.011
    )  # the last trough is faded
    page = sending(tmp_path)
    assert page.displays() == {"pump.toml": "A pump that is never off"}
    sent = page.drive(DriveRequest("file:touch.wav", "pump.toml", "peak=1"))
    assert sent.facts["report"]["family"] == "biased"
    output = DisplayOutput(open_display("pump.toml"), touch, level=parse_level("peak=1"))
    output.process(np.zeros((1, 100), np.float32))  # fades in
    factor = output.facts()["factor"]
    assert factor == pytest.approx(0.2, rel=0.02)
    assert output.process(touch.samples)[0, 300:] == pytest.approx(0.5 + factor * touch.samples[0, 300:])
    capsys.readouterr()
    (tmp_path / "pump.toml").write_text((tmp_path / "pump.toml").read_text().replace("biased", "pumped"))
    assert main(["displays", "pump.toml"]) == 1
    assert "family must be one of amplitude_stream, biased," in capsys.readouterr().err


@pytest.mark.parametrize("recipe", ["importer"], indirect=True)
def test_an_importer_is_one_file(recipe, tmp_path, capsys):
    modules, commands = recipe
    assert len(modules) == 1
    (tmp_path / "takes").mkdir()
    for take in (1, 2, 10):
        np.savetxt(tmp_path / "takes" / f"cork_{take}.txt", np.arange(5.0) + take)
    assert [main(command) for command in commands] == [0, 0, 0]
    assert "Bench recordings, MATERIAL_TAKE.txt" in capsys.readouterr().out
    store = open_store(tmp_path / "store")
    assert [info.source for info in store.index] == ["cork_1.txt", "cork_2.txt", "cork_10.txt"]
    assert {info.material for info in store.index} == {"cork"}
    signal = store.signal(store.index[2].id, "acceleration")
    assert (signal.rate, signal.samples.tolist()) == (2000, [[10, 11, 12, 13, 14]])
    modules[0].write_text(modules[0].read_text().replace("TITLE", "NAME"))
    sys.modules.pop("bench")
    assert main(["data", "list"]) == 1
    assert "must define TITLE, LICENCE, DESCRIPTION, find, read, lacks TITLE" in capsys.readouterr().err


@pytest.fixture(name="store", scope="module")
def store_fixture(tmp_path_factory):
    """Give a store of two materials."""
    folder = tmp_path_factory.mktemp("store") / "store"
    rng = np.random.default_rng(0)
    recordings = [
        Recording(
            streams={"acceleration": Signal(gain * rng.standard_normal((3, 500)), 500, "m/s^2")},
            material=name,
        )
        for name, gain in (("cork", 1), ("tile", 3))
        for _ in range(4)
    ]
    create_store(folder, recordings, name="noise", licence="made in a test", simulated=True)
    return folder


@pytest.mark.parametrize("recipe", ["measure"], indirect=True)
def test_a_measure_is_one_file(recipe, store, tmp_path, capsys):
    modules, [command] = recipe
    assert len(modules) == 1
    assert main(["train", "ar_texture", "--recipe", "tiny", "--data", str(store), "--out", "run"]) == 0
    assert main([*command, "--evaluation", "steps=4", "--evaluation", "most=2"]) == 0
    assert "kurtosis_difference" in capsys.readouterr().out
    row = json.loads((tmp_path / "run/evaluation.json").read_text())["measures"]["kurtosis_difference"]
    assert {"model", "floor", "ceiling"} <= {column for column, value in row.items() if value is not None}
    assert "difference in kurtosis" in (tmp_path / "run/report.html").read_text()


@pytest.mark.parametrize("recipe", ["capture source"], indirect=True)
def test_a_capture_source_is_one_file(recipe, store, tmp_path, capsys):
    modules, commands = recipe
    assert len(modules) == 1
    train = ["train", "stroke_cnn", "--recipe", "tiny", "--data", str(store), "--out", "run"]
    assert main(train) == 0
    np.save(tmp_path / "stroke.npy", np.random.default_rng(0).standard_normal((3, 3000)))
    capsys.readouterr()
    listed, probed, live = ([main(command), capsys.readouterr().out] for command in commands)
    assert (listed[0], probed[0], live[0]) == (0, 0, 0)
    assert re.search(r"npy:stroke.npy +a stroke", listed[1])
    assert probed[1].startswith("npy: works: devices: npy:stroke.npy")
    assert live[1]
    assert main(["live", "run", "--source", "npy:"]) == 1
    assert "npy: must name the file after the colon" in capsys.readouterr().err


@pytest.mark.parametrize("kind", KINDS)
def test_modules_are_listed_without_being_imported(kind, tmp_path, monkeypatch):
    (tmp_path / "broken.py").write_text("raise ImportError('read, not imported')")
    monkeypatch.setenv(KINDS[kind].group.variable, str(tmp_path / "broken.py"))
    assert "broken" in KINDS[kind].group.names()
