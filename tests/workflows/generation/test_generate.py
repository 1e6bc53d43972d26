"""Generated signals: of materials described in English, to files, limited to what was learned, and what is refused."""

import json
import shlex
import shutil
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tactogram.cli import main
from tactogram.datasets import Recording, create_store
from tactogram.datasets.store.photographs import photograph_of
from tactogram.errors import MissingExtraError, ParameterError
from tactogram.features import text_classifier
from tactogram.features.text_classifier import mixed
from tactogram.model import Limit, Model, SignalKind, limits_within, word_limits
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_metadata, read_signal, write_image, write_signal
from tactogram.signal.motion import Motion
from tactogram.workflows.generation.generate import generate, generate_files, limits, with_materials, within
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train
from tactogram_studio.generation.runs import GeneratingRuns
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive


@pytest.mark.parametrize(
    ("condition", "options", "message"),
    [
        ("cork", {}, "condition must be Mapping"),
        ({"material": {"no such": 1}}, {}, "material must be one of"),
        ({"colour": 1}, {}, "condition 'colour' is not one this model takes"),
        ({"material": {"cork": 1}}, {"count": "many"}, "count must be int, got 'many'"),
        ({"material": {"cork": 1}}, {"seconds": -1}, "seconds must be > 0"),
    ],
)
def test_the_call_itself_refuses_what_is_wrong(condition, options, message):
    with pytest.raises(ParameterError, match=message):
        generate("texture_flow", condition, **options)


def test_a_described_material_is_that_material():
    described, named = (
        next(generate("texture_flow", {**given, "speed_mm_s": 100.0}, seconds=1)).samples
        for given in ({"text": "corduroy trousers"}, {"material": "corduroy"})
    )
    assert (described == named).all()


def test_a_file_tells_what_was_described_and_what_was_taken(tmp_path, capsys):
    out = tmp_path / "x.wav"
    told = ["generate", "texture_flow", "--text", "lego bricks", "--seconds", "1", "--out", str(out)]
    assert main([*told, "--json"]) == 0
    [written] = json.loads(capsys.readouterr().out)["files"]
    assert written["text"] == "lego bricks"
    assert written["material"] == {"studded-plastic": 1.0}
    assert "not_understood" not in written
    told[3] = "wet lego bricks"
    assert main(told) == 0
    assert "described: studded-plastic 1; not understood: wet" in capsys.readouterr().out
    assert read_metadata(out)["not_understood"] == ["wet"]
    told[3] = "heart beat"
    assert main(told) == 1
    assert "is an effect, no material; `tactogram effect heartbeat --out FILE`" in capsys.readouterr().err


def test_a_surface_is_described_once_and_by_a_run_that_knows_materials():
    run = load_run("texture_flow")
    assert with_materials(run, {"material": "silk", "speed_mm_s": 9.0}) == {
        "material": "silk",
        "speed_mm_s": 9.0,
    }
    with pytest.raises(ParameterError, match="'material' and 'text' describe the surface twice"):
        with_materials(run, {"text": "silk", "material": "silk"})
    for text in ("", " ", 5):
        with pytest.raises(
            ParameterError, match="text must describe a material, e.g. 'corrugated cardboard'"
        ):
            with_materials(run, {"text": text})


def test_without_the_extra_it_says_what_to_install(monkeypatch):
    text_classifier._encoder.cache_clear()
    monkeypatch.setitem(sys.modules, "wordllama", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'tactogram\[text\]'"):
        mixed({"silk": "silk", "satin": "satin"}, synonyms={})


# -- a library of one's own ----------------------------------------------------------------------------------

GRAINS = dict(
    zip(
        (
            "silk", "velvet", "cotton_fabric", "linen_cloth", "satin", "cashmere",
            "granite", "limestone", "marble", "sandstone", "slate", "basalt",
        ),
        np.linspace(0.5, 4.0, 12),
        strict=True,
    )
)  # fmt: skip
"""Simulated: the coarser a material looks, in pixels, the louder it feels."""


def photograph(grain, seed):
    noise = gaussian_filter(np.random.default_rng(seed).standard_normal((224, 224)), grain)
    grey = np.clip(0.5 + 0.12 * noise / noise.std(), 0, 1)
    return Image(np.uint8(255 * np.repeat(grey[..., None], 3, axis=2)))


def library(folder, looks):
    def recording(number, grain, name):
        x = np.random.default_rng(number).standard_normal((1, 2000))
        signal = Signal(0.03 * 2.4**grain * x, 1000.0, "m/s^2", ("z",))
        return Recording(streams={"acceleration": signal}, material=name, simulated=True)

    store = create_store(
        folder / "store",
        [recording(10 * k + turn, g, n) for k, (n, g) in enumerate(GRAINS.items()) for turn in range(2)],
        name="library",
        licence="none",
        simulated=True,
        photographs=[(name, photograph(grain, k)) for k, (name, grain) in enumerate(looks.items())],
    )
    return train(
        "texture_flow", store.path, recipe="tiny", split="all", out=folder / "run", accelerator="cpu"
    )


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    return library(tmp_path_factory.mktemp("own"), GRAINS).folder


def generated(run, tmp_path, capsys, *described):
    out = tmp_path / "x.wav"
    (tmp_path / "coarse.png").write_bytes(photograph_of(photograph(3.7, 99)).data)
    assert main(["generate", str(run), "--seconds", "1", *described, "--out", str(out)]) == 0
    return capsys.readouterr().out, read_metadata(out), read_signal(out).samples.std()


def test_photograph_and_text_predict_a_surface_that_the_run_does_not_know(own, tmp_path, capsys):
    image = ("--image", str(tmp_path / "coarse.png"))
    printed, facts, level = generated(own, tmp_path, capsys, *image, "--text", "flint stone")
    assert "predicted from the photograph and text, which explains " in printed
    assert "of the variance of this run's 12 materials, each left out; standard deviation " in printed
    assert (facts["text"], facts["prediction"]["given"]) == ("flint stone", ["image", "text"])
    assert facts["prediction"]["mean"] is False
    assert "material" not in facts
    assert level == pytest.approx(0.03 * 2.4**3.7, rel=0.5)
    printed, facts, level = generated(own, tmp_path, capsys, *image)
    assert "predicted from the photograph, which explains" in printed
    printed, facts, _ = generated(own, tmp_path, capsys, "--text", "flint stone")
    assert facts["prediction"]["given"] == ["text"]
    assert "the text" in printed


def test_the_exact_name_of_a_known_material_gives_that_material(own, tmp_path, capsys):
    printed, facts, level = generated(own, tmp_path, capsys, "--text", "Cotton fabric")
    assert "described: cotton_fabric 1" in printed
    assert facts["material"] == {"cotton_fabric": 1.0}
    assert "prediction" not in facts
    assert level == pytest.approx(0.03 * 2.4 ** GRAINS["cotton_fabric"], rel=0.3)


@pytest.mark.parametrize(("text", "unlike"), [("xyzzy", True), ("flint stone", False)])
def test_a_run_that_predicts_says_of_a_text_that_it_is_like_no_known_name(
    own, tmp_path, capsys, text, unlike
):
    printed, facts, _ = generated(own, tmp_path, capsys, "--text", text)
    assert facts["prediction"]["unlike"] is unlike
    assert ("the text is like no material's name" in printed) is unlike


@pytest.mark.parametrize("photographed", [False, True])
def test_the_page_make_generates_from_text_and_photograph_as_the_command_line_does(
    own, tmp_path, capsys, monkeypatch, photographed
):
    workspace = Workspace(tmp_path)
    shutil.copytree(own, tmp_path / "runs/own")
    write_image(tmp_path / "coarse.png", photograph(3.7, 99))
    state = MakePageState(workspace, ResultArchive(tmp_path / "shelf"), GeneratingRuns(workspace), {})
    state.choose("runs/own")
    state.set(image="coarse.png" * photographed, seconds=0.5, seed=3)
    assert state.runs.described(state.request.changed(image=""), "slate").weights == {"slate": 1.0}
    asked = state.runs.described(state.request, "flint stone")
    assert asked.values["text"] == "flint stone"
    state.set(text="flint stone")
    [(_, made)] = state.runs.generate(state.request)
    said = state.runs.said(state.request)
    assert said["prediction"]["given"] == (["image", "text"] if photographed else ["text"])
    assert said["described"].startswith(
        "Predicted from the photograph and text, which" if photographed else ""
    )
    assert "the text" in said["described"] or photographed
    monkeypatch.chdir(tmp_path)
    command = shlex.split(state.command())[1:-1]
    assert ("--text" in command, "--image" in command, "--mix" in command) == (True, photographed, False)
    assert main([*command, "made.npz"]) == 0
    assert capsys.readouterr().out.lower().count(said["described"][:-1].lower()) == 1
    np.testing.assert_array_equal(read_signal("made.npz").samples, made.samples)


def test_what_tells_nothing_gives_the_mean_and_the_file_says_so(tmp_path, capsys):
    grains = np.random.default_rng(2).permutation(list(GRAINS.values()))
    run = library(tmp_path, dict(zip(GRAINS, grains, strict=True))).folder
    printed, facts, level = generated(run, tmp_path, capsys, "--image", str(tmp_path / "coarse.png"))
    assert (
        "the mean of all materials was generated, as the photograph may tell nothing: it explains" in printed
    )
    assert facts["prediction"]["mean"] is True
    assert level == pytest.approx(0.03 * 2.4 ** np.mean(list(GRAINS.values())), rel=0.5)


def test_an_everyday_material_says_what_it_was_set_from(tmp_path):
    [made] = generate_files("texture_flow", {"material": "cork"}, tmp_path / "cork.wav", seconds=0.5)
    assert list(made["set_from"]) == ["cork"]
    assert "the mean of 60 real materials" in made["set_from"]["cork"]


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


@pytest.fixture(scope="module")
def voice(store, tmp_path_factory, tiny):
    out = tmp_path_factory.mktemp("runs") / "ar"
    return load_run(train("ar_texture", store, recipe="tiny", out=out, accelerator="cpu").folder)


def test_generated_files_say_what_they_are(voice, tmp_path):
    written = generate_files(
        voice, {"material": {"cork": 0.5, "tile": 0.5}}, tmp_path / "x.wav", seconds=2, count=2
    )
    assert [row["seconds"] for row in written] == [2.0, 2.0]
    first = read_signal(tmp_path / "x-1.wav")
    assert (first.rate, first.unit, first.axes) == (330.0, "m/s^2", ("x", "y", "z"))
    said = read_metadata(tmp_path / "x-1.wav")
    assert said["simulated"] is True
    assert written[0]["simulated"] is True
    assert said["material"] == {"cork": 0.5, "tile": 0.5}
    assert (first.samples != read_signal(tmp_path / "x-2.wav").samples).any()
    again = next(generate(voice, {"material": {"cork": 0.5, "tile": 0.5}}, seconds=2))
    np.testing.assert_array_equal(again.samples, first.samples)


@pytest.mark.parametrize(
    ("condition", "options", "message"),
    [
        ({"material": "glass"}, {}, "material must be one of cork, foam, tile, wool, got 'glass'"),
        ({"material": {"cork": 0.0}}, {}, "at least one material needs a weight > 0"),
        ({"material": "cork"}, {"seconds": 36_000.0}, "seconds must be > 0 and at most 3600, got 36000"),
        ({"material": "cork"}, {"count": 0}, "count must be at least 1"),
        (
            {"material": "cork"},
            {"count": 10**11},
            "count must be at least 1 and at most 100000, got 100000000000",
        ),
        ({"material": "cork", "words": {"rough": 1.0}}, {}, "condition 'words' is not one this model takes"),
    ],
)
def test_conditions_that_mean_nothing_are_refused(voice, condition, options, message):
    with pytest.raises(ParameterError, match=message):
        next(generate(voice, condition, **options))


def test_a_file_that_cannot_hold_a_signal_is_refused_before_one_is_made(voice, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "tactogram.workflows.generation.generate.generate",
        lambda *_, **__: pytest.fail("generated all the same"),
    )
    for name, got in (("x.mp3", ".mp3"), ("x.png", ".png"), ("x", "none")):
        with pytest.raises(ParameterError, match=rf"suffix must be one of \.wav, .*, got {got}"):
            generate_files(voice, {"material": "cork"}, tmp_path / name)
