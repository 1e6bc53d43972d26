"""What is outside of what was learned is limited, and said: by every generator, in results, files and notes."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, create_store
from tactogram.model import Limit, Model, SignalKind, limits_within, word_limits
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram.signal.motion import Motion
from tactogram.workflows.generation.clone import clone
from tactogram.workflows.generation.generate import generate, generate_files, limits, within
from tactogram.workflows.generation.many import generate_many
from tactogram.workflows.streaming.stream import stream
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

FASTEST = "it counts as 399.7 mm/s"


@pytest.fixture(scope="module")
def strokes(tmp_path_factory):
    """Simulated: noise of two levels, recorded at 100 and 200 mm/s."""
    rng = np.random.default_rng(0)
    recordings = [
        Recording(
            streams={"acceleration": Signal(level * speed * rng.standard_normal((1, 2000)), 1000.0, "m/s^2")},
            material=name,
            speed_mm_s=speed,
            simulated=True,
        )
        for name, level in (("cork", 0.1), ("tile", 0.01))
        for speed in (100.0, 200.0)
        for _ in range(3)
    ]
    path = tmp_path_factory.mktemp("strokes") / "store"
    return create_store(path, recordings, name="strokes", licence="-", simulated=True).path


@pytest.mark.parametrize("model", ["ar_texture", "texture_var", "replay", "texture_gan", "texture_flow"])
def test_every_model_of_speeds_says_which_one_counts(model, strokes, tmp_path):
    recipe = "tiny" if model in ("texture_gan", "texture_flow") else "quick"
    run = train(model, strokes, recipe=recipe, out=tmp_path / "run", accelerator="cpu").folder
    cork = {"material": {"cork": 1.0}}
    loaded = load_run(run)
    [limit] = limits(loaded, cork | {"speed_mm_s": 900.0})
    assert (limit.name, limit.given, limit.used) == ("speed_mm_s", 900.0, 200.0)
    assert limits(loaded, cork | {"speed_mm_s": 50.0})[0].used == 100.0
    assert limits(loaded, cork | {"speed_mm_s": 200.0}) == limits(loaded, cork) == []
    [beyond], [fastest] = (
        generate(loaded, cork | {"speed_mm_s": speed}, seconds=1, seed=3) for speed in (900.0, 200.0)
    )
    np.testing.assert_array_equal(beyond.samples, fastest.samples)


def test_a_limited_speed_is_in_the_result_the_file_and_a_note(tmp_path, capsys):
    told = ["generate", "texture_flow", "--material", "corduroy", "--seconds", "0.5", "--json", "--quiet"]
    out = tmp_path / "fast.wav"
    assert main([*told, "--speed", "600", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    [row] = json.loads(printed.out)["files"]
    assert row["limited"] == [f"speed 600 mm/s is outside of what was recorded: {FASTEST}"]
    assert read_metadata(out)["limited"] == row["limited"]
    assert printed.err == f"note: {row['limited'][0]}\n"
    assert main([*told, "--speed", "400", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert "limited" not in json.loads(printed.out)["files"][0]
    assert "limited" not in read_metadata(out)
    assert printed.err == ""


def test_words_are_limited_to_what_was_rated(tmp_path, capsys):
    out = tmp_path / "squishy.wav"
    told = ["generate", "texture_flow", "--words", "squishy=7", "--speed", "150", "--seconds", "1"]
    assert main([*told, "--out", str(out)]) == 0
    [sentence] = read_metadata(out)["limited"]
    assert sentence in capsys.readouterr().err
    most = float(sentence.rpartition(" ")[2])
    assert sentence == f"squishy 7 is outside of what was rated: it counts as {most:.4g}"
    assert 1.5 < most < 6
    loaded = load_run("texture_flow")
    assert within(loaded, {"words": {"squishy": 7.0}})["words"]["squishy"] == pytest.approx(most, rel=1e-3)
    [same] = generate(loaded, within(loaded, {"words": {"squishy": 7.0}, "speed_mm_s": 150.0}), seconds=1)
    np.testing.assert_allclose(read_signal(out).samples, same.samples, atol=1e-4)
    assert np.sqrt((same.samples**2).mean()) < 63 * 9.81 / 5


def test_scores_are_compared_on_the_scale_of_the_ratings():
    kind = SignalKind(1000.0, "m/s^2", ("z",), words=("rough", "tempo", "unrated"), scale=(-3.0, 3.0))
    rated = np.array([[0.5, 0.25, np.nan], [0.75, np.nan, np.nan]])
    found = word_limits({"rough": 3.0, "tempo": -1.5, "unrated": 3.0}, kind, rated)
    assert found == [Limit("rough", 3.0, 1.5, "on the ratings' scale from -3 to 3")]
    assert word_limits({"rough": 9.0}, kind, rated) == []  # off the scale: the model refuses it


def test_a_model_of_rated_items_is_kept_within_them():
    class Rated(Model):
        step = None
        rated_means = {"a": np.array([0.25, 0.5]), "b": np.array([0.5, 0.75])}  # noqa: RUF012

    kind = SignalKind(1000.0, "1", ("z",), words=("rough", "sticky"), scale=(1.0, 7.0))
    run = SimpleNamespace(generator=Rated(None, kind))
    assert within(run, {"words": {"rough": 7.0, "sticky": 5.0}})["words"] == {"rough": 4.0, "sticky": 5.0}
    assert str(limits(run, {"words": {"sticky": 1.0}})[0]).endswith("was rated: it counts as 4")


def test_the_share_of_a_motion_that_is_outside_is_said():
    times = np.array([0, 1, 1.0001, 3, 3.0001, 4])
    speed, force = np.array([100, 100, 600, 600, 5, 5.0]), np.ones(6)
    motion = Motion(times, speed, force)
    ranges = {"speed_mm_s": (30.0, 400.0), "force_n": (0.2, 3.0)}
    slow, fast = limits_within({"motion": motion}, ranges)
    assert (slow.given, slow.used, fast.given, fast.used) == (5, 30, 600, 400)
    assert (slow.share, fast.share) == pytest.approx((0.25, 0.5), abs=0.02)
    assert str(fast).startswith("a speed of up to 600 mm/s, for ")
    assert str(fast).endswith(" % of the motion, is outside of what was recorded: it counts as 400 mm/s")
    resting = Motion(times, speed, force, gain=np.array([1, 1, 1, 1, 0, 0.0]))
    [fast] = limits_within({"motion": resting}, ranges)
    assert fast.share == pytest.approx(2 / 3, abs=0.02)


def slow_stroke(folder):
    """Simulated noise, recorded at 200 Hz."""
    noise = np.random.default_rng(0).standard_normal((1, 800))
    write_signal(folder / "slow.wav", Signal(noise / 8, 200.0, "1"))
    return folder / "slow.wav"


def test_a_recording_says_where_its_band_ends(tmp_path):
    given = {"vibration_speed_mm_s": 900.0, "speed_mm_s": 100.0}
    [row] = generate_files(
        load_run("texture_flow"),
        given,
        tmp_path / "a.wav",
        seconds=0.5,
        options={"vibration": slow_stroke(tmp_path)},
    )
    assert row["limited"] == [
        f"speed 900 mm/s of the given recording is outside of what was recorded: {FASTEST}",
        "the recording ends at 100 Hz: above, up to 1000 Hz in the run's band, nothing is known of the surface",
    ]
    loaded = load_run("texture_flow")
    assert loaded.missing_band(Signal(np.zeros((1, 500)), 2500.0, "m/s^2")) == []


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


def test_a_table_says_which_files_are_limited(tmp_path, capsys):
    table = tmp_path / "conditions.csv"
    table.write_text("material,speed\ncork,60\ncork,600\n")
    made = generate_many("texture_flow", table, tmp_path / "out", seconds=0.25, processes=1)
    assert ["limited" in row for row in made] == [False, True]
    told = ["--conditions", str(table), "--seconds", "0.25", "--processes", "1", "--quiet"]
    assert main(["generate", "texture_flow", *told, "--out", str(tmp_path / "again")]) == 0
    [note] = capsys.readouterr().err.splitlines()
    assert note.startswith(f"note: {tmp_path / 'again' / '2.wav'}: speed 600 mm/s")


def test_a_stream_says_for_how_long_the_finger_was_outside(strokes, tmp_path):
    run = train("texture_var", strokes, out=tmp_path / "run", accelerator="cpu").folder
    motion = tmp_path / "hand.csv"
    rows = [f"{t:.3f},{100 * t if t < 1 else 100 + 400 * (t - 1)}" for t in np.arange(0, 2, 0.005)]
    motion.write_text("\n".join(["time_s,x_mm", *rows]) + "\n")
    out = tmp_path / "felt.wav"
    told = {"mix": {"cork": 1}, "motion": str(motion), "seconds": 1.9, "backend": "file", "out": out}
    [sentence] = stream([run], **told)["limited"]
    assert sentence.endswith("is outside of what was recorded of cork: it counts as 200 mm/s")
    assert sentence.startswith("a speed of up to 4")
    share = float(sentence.split("for ")[1].split(" %")[0])
    assert share == pytest.approx(47, abs=6)
    assert read_metadata(out)["limited"] == [sentence]
