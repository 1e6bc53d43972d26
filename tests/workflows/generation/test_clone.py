"""The model that comes with the package: clones for any speed and force, from a recording or words; haptic files."""

import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import DataError, ParameterError, RunError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_signal, write_image, write_signal
from tactogram.workflows.generation.clone import clone
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train


@pytest.fixture
def stroke(tmp_path):
    """Simulated: noise of 0.2 of full scale."""
    noise = 0.2 * np.random.default_rng(0).standard_normal((1, 8000)).clip(-4, 4)
    write_signal(tmp_path / "mine.wav", Signal(noise, 4000.0, "1"))
    return tmp_path / "mine.wav"


def test_a_clone_plays_at_any_speed_and_force(stroke, tmp_path, capsys):
    out = tmp_path / "clone"
    arguments = ["--out", str(out), "--speed", "100", "--speeds", "50,200", "--forces", "1", "--seconds", "1"]
    assert main(["clone", str(stroke), *arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"run": str(out), "materials": ["mine"]}
    strokes = open_store(tmp_path / "clone-strokes")
    assert strokes.simulated
    assert [(info.speed_mm_s, info.force_n, info.simulated) for info in strokes.index] == [
        (100, 1, False),
        (50, 1, True),
        (200, 1, True),
    ]
    recorded = strokes.signal(strokes.index[0].id, "acceleration")
    prepared = load_run("texture_flow").prepare_vibration(read_signal(stroke))
    np.testing.assert_allclose(recorded.samples, prepared.samples, atol=1e-6)
    assert len(load_run(out).model.maps) == 1
    assert load_run(out).kind.unit == "1"
    told = [
        "--material",
        "mine",
        "--speed",
        "120",
        "--force",
        "1",
        "--seconds",
        "2",
        "--out",
        str(tmp_path / "x.wav"),
    ]
    assert main(["generate", str(out), *told]) == 0
    assert main(["generate", str(out), *told, "--motion", "simulated"]) == 1
    assert "texture_var takes no motion; a stream follows one" in capsys.readouterr().err
    assert 0 < read_signal(tmp_path / "x.wav").samples.std() < 1


def test_a_clone_that_was_interrupted_keeps_its_strokes(tmp_path, monkeypatch):
    surface = {"materials": ["corduroy"], "out": tmp_path / "a", "forces": (1.0,), "seconds": 1.0}

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("tactogram.workflows.generation.clone.train", interrupted)
    with pytest.raises(KeyboardInterrupt):
        clone(**surface, speeds=(100.0, 200.0))
    monkeypatch.undo()
    for speeds in (100.0, 300.0), (100.0,):
        with pytest.raises(DataError, match="a-strokes: holds other strokes"):
            clone(**surface, speeds=speeds)
    left = (tmp_path / "a-strokes" / "dataset.json").read_bytes()
    clone(**surface, speeds=(100.0, 200.0))
    assert load_run(tmp_path / "a").kind.materials == ("corduroy",)
    assert (tmp_path / "a-strokes" / "dataset.json").read_bytes() == left


def test_words_are_cloned_and_generated_without_a_recording(tmp_path):
    run = clone(words={"rough": 6}, out=tmp_path / "words", speeds=(100.0,), forces=(1.0,), seconds=1.0)
    assert run.kind().materials == ("words",)
    assert run.kind().unit == "m/s^2"
    signals = []
    for score in (1, 7):
        out = tmp_path / f"{score}.wav"
        told = ["generate", "texture_flow", "--words", f"rough={score}", "--speed", "100", "--out", str(out)]
        assert main(told) == 0
        signals.append(read_signal(out).samples)
    assert signals[1].std() > 1.5 * signals[0].std()


def test_materials_by_name_are_cloned(tmp_path):
    told = {"speeds": (60.0, 240.0), "forces": (1.0,), "seconds": 1.0}
    run = clone(materials=["brick", "silk"], out=tmp_path / "named", **told)
    assert run.kind().materials == ("brick", "silk")
    brick, silk = (
        [
            signal.samples.std()
            for speed in (60.0, 240.0)
            for signal in generate(
                run.folder, {"material": name, "speed_mm_s": speed, "force_n": 1.0}, seconds=2
            )
        ]
        for name in ("brick", "silk")
    )
    assert brick[0] > 3 * silk[0]
    assert brick[1] > brick[0]


def test_a_photograph_is_cloned_by_a_model_trained_on_some(tmp_path, capsys):
    """Simulated: two smooth surfaces and a rough one, red, green and blue photographs; without forces."""
    rng = np.random.default_rng(0)

    def stroke_of(name, speed):
        noise = (5 if name == "rough" else 1) * speed / 100 * rng.standard_normal((1, 2500))
        streams = {"acceleration": Signal(noise, 1000.0, "m/s^2", ("z",))}
        return Recording(streams=streams, material=name, speed_mm_s=speed, simulated=True)

    def photograph(channel):
        pixels = rng.integers(0, 60, (64, 64, 3), np.uint8)
        pixels[..., channel] += 150
        return Image(pixels)

    colours = {"smooth": 0, "even": 1, "rough": 2}
    store = create_store(
        tmp_path / "seen",
        [stroke_of(name, speed) for name in colours for speed in (50.0, 100.0, 200.0, 300.0)],
        name="seen",
        licence="none",
        simulated=True,
        photographs=[(name, photograph(channel)) for name, channel in colours.items() for _ in range(4)],
    )
    run = train(
        "texture_flow", store.path, recipe="tiny", changes={"config.prediction": True, "config.components": 4},
        split="all", out=tmp_path / "run", accelerator="cpu",
    )  # fmt: skip
    board = np.repeat(255 * (np.indices((64, 64)).sum(0) // 8 % 2)[..., None], 3, axis=2).astype(np.uint8)
    write_image(tmp_path / "photo.png", photograph(2))
    write_image(tmp_path / "board.png", Image(board))
    told = [
        "--model",
        str(run.folder),
        "--speeds",
        "60,240",
        "--seconds",
        "1",
        "--out",
        str(tmp_path / "clone"),
    ]
    images = ["--image", str(tmp_path / "photo.png"), "--image", str(tmp_path / "board.png")]
    assert main(["clone", *images, *told]) == 0
    lines = capsys.readouterr().out.splitlines()
    unlike = [line for line in lines if "photograph unlike anything the run was trained on: " in line]
    assert [line.partition(":")[0] for line in unlike] == ["board"]
    made = [next(generate(tmp_path / "clone", {"material": "photo", "speed_mm_s": v})) for v in (60.0, 240.0)]
    assert made[0].samples.std() == pytest.approx(3, rel=0.4)
    assert made[1].samples.std() == pytest.approx(12, rel=0.4)


def test_what_cannot_be_cloned_is_refused(stroke, tmp_path):
    with pytest.raises(
        ParameterError, match="give a recording of a surface, or `images`, or `materials`, or `words`"
    ):
        clone(out=tmp_path / "a")
    with pytest.raises(ParameterError, match="different names, got 'mine' twice"):
        clone([stroke, stroke], out=tmp_path / "a")
    with pytest.raises(ParameterError, match="material must be one of 84, e.g. denim, got 'dennim'"):
        clone(materials=["dennim"], out=tmp_path / "a")
    silk = stroke.with_name("silk.wav")
    silk.write_bytes(stroke.read_bytes())
    for recordings, materials in (([silk], ["silk"]), ([], ["silk", "silk"])):
        with pytest.raises(ParameterError, match="must have different names, got 'silk' twice"):
            clone(recordings, materials=materials, out=tmp_path / "a")
    with pytest.raises(ParameterError, match="words must be of dry, sleek"):
        clone(words={"loud": 6}, out=tmp_path / "a")
    assert not (tmp_path / "a").exists()
    assert not (tmp_path / "a-strokes").exists()
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "recipe.toml").write_text("")
    with pytest.raises(RunError, match="contains a run"):
        clone([stroke], out=tmp_path / "b")


FASTEST = "it counts as 399.7 mm/s"


def slow_stroke(folder):
    """Simulated noise, recorded at 200 Hz."""
    noise = np.random.default_rng(0).standard_normal((1, 800))
    write_signal(folder / "slow.wav", Signal(noise / 8, 200.0, "1"))
    return folder / "slow.wav"


def test_a_clone_says_what_was_limited(tmp_path, capsys):
    told = ["clone", str(slow_stroke(tmp_path)), "--speeds", "100,600", "--forces", "1", "--seconds", "1"]
    run = clone(
        words={"squishy": 7}, speeds=(100.0, 600.0), forces=(1.0,), seconds=1.0, out=tmp_path / "words"
    )
    squishy, speed = run.facts()["notes"]
    assert squishy.startswith("squishy 7 is outside of what was rated")
    assert speed == f"speed 600 mm/s is outside of what was recorded: {FASTEST}"
    assert main([*told, "--out", str(tmp_path / "slow"), "--json", "--quiet"]) == 0
    printed = capsys.readouterr()
    band, speed = json.loads(printed.out)["limited"]
    assert band.startswith("slow: the recording ends at 100 Hz")
    assert f"note: {speed}\n" in printed.err
