"""Samples for game engines: they parse, and agree with the package on messages and files."""

import json
import re
import struct
from importlib import import_module
from pathlib import Path

import pytest

from tactogram.rendering.motion.finger_state import MixWeights, MotionSample, Tap
from tactogram_playback.streaming.network import parse

ROOT = Path(__file__).parents[1]
ENGINES = ROOT / "examples" / "engines"
UNITY, GODOT = ENGINES / "unity", ENGINES / "godot"
GOLDEN = ROOT / "tests" / "rendering" / "files" / "golden"
OSC_FILES = (UNITY / "TactogramOsc.cs", GODOT / "tactogram_finger.gd")
GRAMMARS = {".cs": "tree_sitter_c_sharp", ".gd": "tree_sitter_gdscript"}


def messages(path):
    """Return the type tags of a sample's messages by address: constants that stand together."""
    return dict(re.findall(r'"(/tactogram/\d+/\w+)".*?"(,\w+)"', path.read_text(), re.DOTALL))


def osc(address, types, *values):
    """Return a message as OSC 1.0 has it: text ends in one to four zeros, numbers are big-endian."""

    def text(content):
        return content.encode() + bytes(4 - len(content.encode()) % 4)

    codes = {"i": ">i", "d": ">d", "f": ">f"}
    parts = (
        text(value) if tag == "s" else struct.pack(codes[tag], value)
        for tag, value in zip(types[1:], values, strict=True)
    )
    return text(address) + text(types) + b"".join(parts)


def document(name):
    return json.loads((GOLDEN / f"burst-{name}.json").read_text())


def fields(class_name, file="TactogramEffect.cs"):
    """Return the public fields of a class of a Unity sample."""
    source = (UNITY / file).read_text()
    body = re.search(rf"class {class_name}\s*{{(.*?)}}", source, re.DOTALL)[1]
    return set(re.findall(r"public [\w\[\]]+ (\w+);", body))


@pytest.mark.parametrize(
    "path", sorted(ENGINES.rglob("*.cs")) + sorted(ENGINES.rglob("*.gd")), ids=lambda p: p.name
)
def test_a_sample_parses(path):
    tree_sitter = pytest.importorskip("tree_sitter")
    grammar = pytest.importorskip(GRAMMARS[path.suffix])
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    assert not parser.parse(path.read_bytes()).root_node.has_error
    assert parser.parse(path.read_bytes() + b"\n(").root_node.has_error


@pytest.mark.parametrize("path", OSC_FILES, ids=lambda path: path.name)
def test_the_messages_are_those_that_a_stream_understands(path):
    found = messages(path)
    motion = osc("/tactogram/1/motion", found["/tactogram/1/motion"], 7, 1.5, 2.0, 3.0, 40.0, 0.5)
    head = b"/tactogram/1/motion\0,idffff\0"
    assert motion == head + struct.pack(">idffff", 7, 1.5, 2.0, 3.0, 40.0, 0.5)
    values = {
        "motion": (8, 1.5, 2.0, 3.0, float("nan"), 0.5),
        "mix": (9, 1.5, "cork", 0.5),
        "tap": (9, 1.5, 0.5),
    }
    kinds = {"motion": MotionSample, "mix": MixWeights, "tap": Tap}
    assert set(found) >= {"/tactogram/1/motion", "/tactogram/1/mix"}
    for address, types in found.items():
        name = address.rpartition("/")[2]
        (received,) = parse(osc(address, types, *values[name]), 0.0)
        assert isinstance(received.message, kinds[name])
        assert received.sequence == values[name][0]


def test_unity_reads_the_keys_that_are_written():
    pad, phone = document("gamepad"), document("android_envelope")
    assert fields("Effect") == set(pad["effects"][0])
    assert fields("ControlPoint") == set(phone["controlPoints"][0])
    assert fields("Document") == {"format", "effects", "initialFrequencyHz", "controlPoints"}
    assert fields("Document") <= set(pad) | set(phone)
    source = (UNITY / "TactogramEffect.cs").read_text()
    assert {f'"{pad["format"]}"', f'"{phone["format"]}"'} <= set(re.findall(r'"[\w-]+"', source))


def test_godot_reads_the_keys_that_are_written():
    pad, source = document("gamepad"), (GODOT / "tactogram_effect.gd").read_text()
    assert re.search(r'FORMAT := "(.*?)"', source)[1] == pad["format"]
    assert set(re.findall(r'effect\["(\w+)"\]', source)) == set(pad["effects"][0])
    assert set(re.findall(r'document\["(\w+)"\]', source)) <= set(pad)


def a_texture():
    return json.loads((ROOT / "examples" / "web" / "corduroy.json").read_text(encoding="utf-8"))


def test_unity_reads_the_texture_that_the_pad_reads():
    texture, of_a_surface = a_texture(), {"along", "vibration_step_mm"}
    document = fields("Document", "TactogramTexture.cs")
    assert document - of_a_surface == {"format", "version", "kind", "arrays"}
    assert document <= set(texture) | of_a_surface
    assert fields("Arrays", "TactogramTexture.cs") == {"speeds", "forces", "vibration"} & set(
        texture["arrays"]
    )
    assert fields("Numbers", "TactogramTexture.cs") < set(texture["arrays"]["vibration"])
    source = (UNITY / "TactogramTexture.cs").read_text()
    assert re.search(r'Format = "(.*?)"', source)[1] == texture["format"]
    assert re.search(r"Version = (\d+)", source)[1] == str(texture["version"])


def test_godot_reads_the_texture_that_the_pad_reads():
    texture, source = a_texture(), (GODOT / "tactogram_texture.gd").read_text()
    assert re.search(r'FORMAT := "(.*?)"', source)[1] == texture["format"]
    assert re.search(r"VERSION := (\d+)", source)[1] == str(texture["version"])
    read = set(re.findall(r'texture\["(\w+)"\]', source)) - {"along", "vibration_step_mm"}
    assert read == {"arrays", "kind"}
    arrays = set(re.findall(r'\["arrays"\]\["(\w+)"\]\["values"\]', source))
    assert arrays == {"speeds", "forces", "vibration"} & set(texture["arrays"])


def test_the_builders_calls_are_those_of_the_format():
    module = import_module("tactogram.rendering.files.formats.android_envelope")
    source = (UNITY / "TactogramEffect.cs").read_text()
    called = re.search(r'"addControlPoint", point\.(\w+), point\.(\w+), point\.(\w+)', source).groups()
    assert called == module.BUILDER.point
