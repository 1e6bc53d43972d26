"""Haptic files through `convert`: any to any, a folder at once, checks."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import DataError, ParameterError
from tactogram.rendering.displays.catalogue import FOLDER as SHIPPED
from tactogram.rendering.files import check_file, haptic_formats
from tactogram.rendering.files.reading import read_haptic
from tactogram.signal import Image, Signal
from tactogram.signal.io import WRITABLE, read_image, read_metadata, read_signal, write_image, write_signal
from tactogram.workflows.data.convert import convert

RATE = 2000


FORMATS = haptic_formats()


NAMES = {f"x{suffix}": None for suffix in WRITABLE} | {f"{n}{k.suffix}": n for n, k in FORMATS.items()}
"""Files by name, with their format where the suffix does not say it."""


GOLDEN = Path(__file__).parents[2] / "rendering" / "files" / "golden"


def effect(axes=1, unit="1", seconds=1.0):
    t = np.arange(round(seconds * RATE)) / RATE
    x = 0.9 * (0.5 - 0.5 * np.cos(2 * np.pi * 2 * t / seconds)) * np.sin(2 * np.pi * 150 * t)
    return Signal(np.stack([x / (k + 1) for k in range(axes)]), RATE, unit, tuple("abc"[:axes]))


def made(path, format=None, seconds=1.0):
    source = path.parent / "made.wav"
    write_signal(source, effect(seconds=seconds))
    convert(source, path, format=format)
    source.unlink()
    return path


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sources")
    for name, format in NAMES.items():
        made(folder / name, format, seconds=0.25)
    return folder


PAIRS = [
    (source, target)
    for place, source in enumerate(NAMES)
    for step, target in enumerate(NAMES)
    if (step - place) % len(NAMES) in (0, 1, len(NAMES) // 2) or "x.wav" in (source, target)
]
"""Every format is read and written several times; what reads a file knows nothing of what writes the other."""


@pytest.mark.parametrize(("source", "target"), PAIRS)
def test_any_to_any(sources, tmp_path, source, target):
    facts = convert(sources / source, tmp_path / target, format=NAMES[target])
    if NAMES[target]:
        assert check_file(tmp_path / target)["valid"]
        assert facts["written"]["format"] == NAMES[target]
    else:
        assert read_signal(tmp_path / target).seconds == pytest.approx(0.25, abs=0.04)
    assert ("read" in facts) == (NAMES[source] is not None)


def test_the_carrier_is_stated_in_what_is_made_of_an_envelope(tmp_path):
    made(tmp_path / "a.ahap")
    facts = convert(tmp_path / "a.ahap", tmp_path / "b.wav")
    assert facts["read"]["carrier_hz"] == [65, 300]
    assert read_metadata(tmp_path / "b.wav")["read_from"] == facts["read"]
    assert facts["rate_hz"] == 8000
    assert convert(tmp_path / "a.ahap", tmp_path / "b.wav", rate=2000)["rate_hz"] == 2000


def test_metadata_goes_along_and_the_level_comes_back(tmp_path):
    write_signal(tmp_path / "a.wav", effect(3, "m/s^2"), metadata={"simulated": True})
    facts = convert(tmp_path / "a.wav", tmp_path / "a.ahap")
    assert facts["reduced_by"] == facts["written"]["reduced_by"] == "DFT321 of a, b, c"
    back = convert(tmp_path / "a.ahap", tmp_path / "b.wav")
    assert back["metadata"]["simulated"] is True
    assert back["unit"] == "m/s^2"
    one = convert(tmp_path / "a.wav", tmp_path / "c.wav", axis="dft321")
    assert (one["axes"], one["reduced_by"]) == (["dft321"], "DFT321 of a, b, c")
    assert back["rms"] == pytest.approx(one["rms"], rel=0.03)


def test_full_scale_is_of_the_haptic_file(tmp_path):
    write_signal(tmp_path / "a.wav", effect())
    facts = convert(tmp_path / "a.wav", tmp_path / "a.haptic", full_scale=2)
    assert (facts["written"]["full_scale"], facts["written"]["scaled_by"]) == (2, 0.5)
    assert convert(tmp_path / "a.haptic", tmp_path / "b.csv")["rms"] == pytest.approx(facts["rms"], rel=0.03)


def test_a_pattern_is_made_for_the_motor_of_a_display(tmp_path, capsys):
    (tmp_path / "mine.toml").write_text(
        (SHIPPED / "phone-on-off.toml").read_text().replace("shortest_ms = 40", "shortest_ms = 35")
    )
    t = np.arange(RATE) / RATE
    write_signal(tmp_path / "a.wav", Signal((t % 0.2 < 0.02) * np.sin(2 * np.pi * 150 * t), RATE, "1"))
    arguments = [str(tmp_path / "a.wav"), str(tmp_path / "b.json"), "--format", "vibration"]
    assert main(["convert", *arguments, "--display", str(tmp_path / "mine.toml")]) == 0
    assert json.loads((tmp_path / "b.json").read_text())["pattern"][::2] == [35] * 5
    assert main(["convert", *arguments]) == 0
    assert json.loads((tmp_path / "b.json").read_text())["pattern"][::2] == [40] * 5


def test_a_sound_is_mapped_to_a_file_of_any_kind(tmp_path, capsys):
    t = np.arange(44_100) / 44_100
    song = 0.3 * np.sin(2 * np.pi * 1000 * t)
    write_signal(tmp_path / "a.wav", Signal(np.stack([song, song]), 44_100, "1", ("left", "right")))
    assert (
        main(["convert", str(tmp_path / "a.wav"), str(tmp_path / "b.haptic"), "--map", "pitch", "--json"])
        == 0
    )
    facts = json.loads(capsys.readouterr().out)
    mapped = {"by": "pitch", "octaves_down": 1, "voiced": pytest.approx(1, abs=0.02)}
    assert facts["mapped"] == mapped | {"touch_hz": pytest.approx([500, 500], rel=0.01)}
    assert (facts["reduced_by"], facts["written"]["full_scale"]) == ("mean of left, right", 1)
    facts = convert(tmp_path / "a.wav", tmp_path / "b.wav", map="bands", axis="left", resample_to=2000)
    assert (facts["rate_hz"], facts["axes"], facts["rms"]) == (
        2000,
        ["z"],
        pytest.approx(0.3 / 2**0.5, rel=0.02),
    )
    assert read_metadata(tmp_path / "b.wav")["mapped"] == {"by": "bands", "touch_hz": [50, 400]}


def test_friction_is_felt_at_a_speed(tmp_path):
    x = 0.4 + 0.1 * np.sin(2 * np.pi * np.arange(4000) / 40)
    write_signal(tmp_path / "a.npz", Signal(x, 40, "1", ("along",), "displacement"))
    with pytest.raises(ParameterError, match="at a speed first"):
        convert(tmp_path / "a.npz", tmp_path / "a.ahap")
    facts = convert(tmp_path / "a.npz", tmp_path / "a.ahap", play_at=100.0)
    assert facts["written"]["loss"]["frequency_octaves"] < 0.01
    assert convert(tmp_path / "a.npz", tmp_path / "a.hjif")["rate_per_mm"] == 40


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"target": "b.json"},
            "several formats are written as .json; format must be one of android, android_basic, android_envelope",
        ),
        ({"target": "b.ahap", "format": "haptic"}, "format haptic is written as .haptic, got b.ahap"),
        ({"target": "b.wav", "format": "csv"}, "format csv is written as .csv, got b.wav"),
        ({"target": "b.wav", "format": "mp3"}, "format must be one of ahap"),
        ({"target": "b.ahap", "subtype": "PCM_16"}, "subtype is of WAV and FLAC"),
        ({"target": "b.wav", "modality": "Force"}, "modality is for haptic formats, b.wav is none"),
        ({"target": "b.ahap", "modality": "Force"}, "Apple. has no modalities; omit modality"),
        (
            {"target": "b.wav", "display": "phone-on-off"},
            "display is for patterns of on and off, b.wav is none",
        ),
        ({"target": "b.ahap", "display": "phone-on-off"}, "Apple. does not only switch on and off; omit"),
        ({"target": "b.ahap", "axis": "q"}, "axis must be one of a, dft321, mean"),
        (
            {"target": "b.wav", "map": "pitch", "play_at": 100.0},
            "map is for a sound, which is over time; omit",
        ),
        (
            {"target": "b.mp3"},
            r"suffix must be one of \.wav.* \.ahap, .* \.haptic, ",
        ),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(tmp_path, options, message):
    write_signal(tmp_path / "a.wav", effect())
    target = tmp_path / options.pop("target")
    with pytest.raises(ParameterError, match=message):
        convert(tmp_path / "a.wav", target, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["a.wav"]


def test_what_a_haptic_file_has_no_use_for_is_said(tmp_path):
    made(tmp_path / "a.ahap")
    with pytest.raises(ParameterError, match="no use for unit; omit it"):
        convert(tmp_path / "a.ahap", tmp_path / "b.wav", unit="N")


def test_a_folder_is_converted_with_its_folders(tmp_path):
    write_signal(tmp_path / "in" / "a.wav", effect())
    write_signal(tmp_path / "in" / "deep" / "b.csv", effect(3))
    (tmp_path / "in" / "c.wav").write_bytes(b"RIFF")
    (tmp_path / "in" / "notes.md").write_text("x")
    facts = convert(tmp_path / "in", tmp_path / "out", format="ahap")
    names = sorted(
        path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.ahap")
    )
    assert names == ["a.ahap", "deep/b.ahap"]
    assert list(facts["failed"]) == [str(tmp_path / "in" / "c.wav")]
    assert (facts["left_out"], len(facts["files"])) == (1, 2)
    again = convert(tmp_path / "out", tmp_path / "wav", format="wav")
    assert len(again["files"]) == 2


NOTE = "Recorded in 2025 at 1000 Hz.\n\n1. hold the pen\n2. stroke, 3 times\n"


def test_notes_among_the_files_are_skipped_and_named(tmp_path, capsys):
    write_signal(tmp_path / "in" / "a.wav", effect())
    (tmp_path / "in" / "NOTE.txt").write_text(NOTE)
    (tmp_path / "in" / "who.txt").write_text("subject: 1\nage: 30\n")
    (tmp_path / "in" / "README.md").write_text(NOTE)
    assert main(["convert", str(tmp_path / "in"), str(tmp_path / "out"), "--to", "ahap"]) == 0
    *_, skipped, end = capsys.readouterr().out.splitlines()
    names = f"{tmp_path / 'in' / 'NOTE.txt'}, {tmp_path / 'in' / 'who.txt'}"
    assert skipped == f"skipped, no table of numbers: {names}"
    assert end == "1 written, 0 failed, 1 of no known format"
    (tmp_path / "in" / "a.wav").unlink()
    with pytest.raises(DataError, match="no file in it can be read"):
        convert(tmp_path / "in", tmp_path / "out", format="ahap")


@pytest.mark.parametrize(
    "text",
    ["", "1\n2\n3\n", "t;x\n0,1;2\n", "x: 0.1\n---\nx: 0.2\n---\nx: 0.3\n", "a 1 N\na 2 N\na 3 N\n"],
)
def test_a_table_that_cannot_be_read_is_no_note(tmp_path, text):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.txt").write_text(text)
    facts = convert(tmp_path / "in", tmp_path / "out", format="ahap")
    assert (list(facts["failed"]), facts["notes"]) == ([str(tmp_path / "in" / "a.txt")], [])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("x.xml", '<vibration-effect><primitive-effect name="click" scale="0.5"/></vibration-effect>'),
        ("x.json", '{"composition": [{"primitive": "click", "scale": 1, "delayMs": 10}]}'),
        ("list.json", '[{"primitive": 1, "scale": 0.5, "delay": 10}]'),
    ],
)
def test_a_composition_of_primitives_is_refused_with_what_to_write(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    message = "compositions of primitives are not read, .* timings and amplitudes, or as an envelope"
    with pytest.raises(DataError, match=message):
        convert(tmp_path / name, tmp_path / "x.ahap")
    with pytest.raises(DataError, match=message):
        convert(tmp_path / name, check=True)


def test_a_folder_inside_its_source_is_not_read_again(tmp_path):
    write_signal(tmp_path / "a.wav", effect())
    for _ in range(2):
        assert len(convert(tmp_path, tmp_path / "out", format="hjif")["files"]) == 1


def test_a_designed_file_is_converted_and_the_sound_beside_it_is_named(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    shutil.copy(GOLDEN / "my.haptic", tmp_path / "in" / "Tap1.haptic")
    write_signal(tmp_path / "in" / "Tap1.wav", effect())
    facts = convert(tmp_path / "in", tmp_path / "out", format="ahap")
    assert [Path(file["source"]).name for file in facts["files"]] == ["Tap1.haptic"]
    assert facts["beside"] == {str(tmp_path / "in" / "Tap1.wav"): str(tmp_path / "in" / "Tap1.haptic")}
    assert main(["convert", str(tmp_path / "in"), str(tmp_path / "out"), "--to", "ahap"]) == 0
    assert "Tap1.wav, beside" in capsys.readouterr().out


def test_of_a_design_in_several_formats_one_is_converted_and_no_source_overwritten(tmp_path):
    source = tmp_path / "in"
    source.mkdir()
    shutil.copy(GOLDEN / "my.haptic", source / "hit.haptic")
    convert(source / "hit.haptic", source / "hit.ahap")
    write_signal(source / "hit.wav", effect())
    for format, first in (("haptic", "hit.haptic"), ("ahap", "hit.ahap"), ("tact", "hit.ahap")):
        facts = convert(source, tmp_path / format, format=format)
        assert [file["source"] for file in facts["files"]] == [str(source / first)]
        assert set(facts["beside"].values()) == {str(source / first)}
        assert len(facts["beside"]) == 2
    before = (source / "hit.haptic").read_bytes()
    with pytest.raises(ParameterError, match="hit.haptic would be overwritten; choose another folder"):
        convert(source, source, format="haptic")
    with pytest.raises(ParameterError, match="would overwrite its source; choose another target"):
        convert(source / "hit.haptic", source / "hit.haptic")
    assert (source / "hit.haptic").read_bytes() == before


def test_a_click_in_silence_is_one_transient(tmp_path, capsys):
    x = np.zeros(2 * RATE)
    x[RATE : RATE + 4] = 0.9
    write_signal(tmp_path / "click.wav", Signal(x, RATE, "1"))
    assert main(["convert", str(tmp_path / "click.wav"), str(tmp_path / "click.ahap")]) == 0
    [entry] = json.loads((tmp_path / "click.ahap").read_text())["Pattern"]
    assert entry["Event"]["EventType"] == "HapticTransient"
    assert entry["Event"]["Time"] == pytest.approx(1.0, abs=0.005)


def test_events_become_a_waveform_only_where_one_is_asked_for(tmp_path):
    events = convert(GOLDEN / "my.haptic", tmp_path / "x.ahap")["written"]
    assert events["events"]["kept"] == events["events"]["transients"] == 1
    analysed = convert(GOLDEN / "my.haptic", tmp_path / "x.ahap", resample_to=2000.0)["written"]
    assert "events" not in analysed


def test_several_channels_of_waves_remain_where_the_target_holds_them(tmp_path):
    document = json.loads((GOLDEN / "min.hjif").read_text())
    [channel] = document["perceptions"][0]["channels"]
    document["perceptions"][0]["channels"].append(channel | {"id": 7, "description": "second", "gain": 0.5})
    (tmp_path / "two.hjif").write_text(json.dumps(document))
    assert len(convert(tmp_path / "two.hjif", tmp_path / "x.hjif")["axes"]) == 2
    assert len(read_haptic(tmp_path / "x.hjif").signal.axes) == 2
    found = convert(tmp_path / "two.hjif", tmp_path / "x.ahap")["written"]
    assert found["told"][-1] == "Not read: of 2 channels as events all but the strongest at any time."
    halved = convert(tmp_path / "two.hjif", tmp_path / "x.ahap", axis="second")
    assert halved["reduced_by"].startswith("axis second of")


def test_two_files_that_would_become_one_are_refused(tmp_path):
    write_signal(tmp_path / "in" / "a.wav", effect())
    write_signal(tmp_path / "in" / "a.csv", effect())
    with pytest.raises(ParameterError, match="would both become"):
        convert(tmp_path / "in", tmp_path / "out", format="ahap")
    assert not (tmp_path / "out").exists()
    with pytest.raises(ParameterError, match="format must be one of ahap"):
        convert(tmp_path / "in", tmp_path / "out", format="mp3")
    (tmp_path / "none").mkdir()
    with pytest.raises(DataError, match="no file in it can be read"):
        convert(tmp_path / "none", tmp_path / "out", format="ahap")


@pytest.mark.parametrize("name", ["min.hjif", "my.haptic"])
def test_files_of_others_are_checked_and_converted(tmp_path, name, capsys):
    assert main(["convert", "--check", str(GOLDEN / name)]) == 0
    assert "valid" in capsys.readouterr().out
    assert main(["convert", str(GOLDEN / name), str(tmp_path / "x.wav"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["samples"] == 8000


def test_a_sound_is_checked_by_reading_it(tmp_path):
    write_signal(tmp_path / "a.wav", effect())
    assert convert(tmp_path / "a.wav", check=True) == {
        "file": str(tmp_path / "a.wav"),
        "format": "wav",
        "valid": True,
        "problems": [],
        "columns": [],
        "notes": [],
    }
    (tmp_path / "b.wav").write_bytes(b"RIFF")
    assert not convert(tmp_path / "b.wav", check=True)["valid"]


@pytest.fixture
def ribs(tmp_path):
    """Give a photograph of ten ribs, bright on top."""
    heights = 128 + 100 * np.sin(2 * np.pi * np.arange(500) / 50)
    pixels = np.broadcast_to(heights[None, :, None], (60, 500, 3))
    write_image(tmp_path / "ribs.png", Image(pixels.astype(np.uint8)))
    return tmp_path / "ribs.png"


@pytest.mark.parametrize("suffix", [".ahap", ".haptic", ".hjif", ".wav"])
def test_a_photograph_is_drawn_as_a_relief(ribs, suffix):
    facts = convert(ribs, ribs.with_suffix(suffix), width_mm=50, play_at=250)
    assert facts["mapped"] == {"by": "relief", "width_mm": 50, "speed_mm_s": 250}
    assert facts["samples"] / facts["rate_hz"] == pytest.approx(0.2)
    signal = read_haptic(ribs.with_suffix(suffix)).signal if suffix == ".haptic" else None
    assert signal is None or signal.seconds == pytest.approx(0.2, abs=0.03)


def test_what_is_drawn_of_a_simulated_picture_is_simulated(ribs):
    write_image(ribs, read_image(ribs), metadata={"simulated": True})
    convert(ribs, ribs.with_suffix(".wav"))
    assert read_metadata(ribs.with_suffix(".wav"))["simulated"] is True


def test_a_drawn_photograph_is_called_a_design(ribs, capsys):
    assert main(["convert", str(ribs), str(ribs.with_suffix(".ahap"))]) == 0
    assert "a design, no prediction of how the material feels" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["unit", "axis", "map"])
def test_a_photograph_has_no_use_for_options_of_signals(ribs, name):
    values = {"unit": "N", "axis": "mean", "map": "bands"}
    with pytest.raises(ParameterError, match=f"a photograph has no use for {name}; omit it"):
        convert(ribs, ribs.with_suffix(".wav"), **{name: values[name]})
    assert not ribs.with_suffix(".wav").exists()


def test_only_a_photograph_has_a_width(tmp_path):
    write_signal(tmp_path / "a.wav", Signal(np.ones((1, 100)), 1000, "1"))
    with pytest.raises(ParameterError, match=r"width_mm is of a photograph, a\.wav is none"):
        convert(tmp_path / "a.wav", tmp_path / "b.wav", width_mm=50)
