import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.recipe import Preparation, Recipe, TrainingSettings, parse_changes, run_id
from tactogram.signal import Signal


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "r.toml"
    path.write_text('model = "stroke_cnn"\n[prepare]\nband = [20, 1000]\nrate = "band"\n')
    return path


def test_a_file_holds_only_what_differs(file):
    recipe = Recipe.load(file)
    assert recipe.prepare == Preparation(band=(20, 1000), rate="band")
    assert recipe.training == TrainingSettings()


def test_changes_replace_values_by_dotted_key(file):
    recipe = Recipe.load(file, changes=parse_changes(["prepare.rate=2000", "config.steps=5", "seed=3"]))
    assert (recipe.prepare.rate, recipe.config, recipe.seed) == (2000, {"steps": 5}, 3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("prepare.rat=1", "unknown key 'prepare.rat'; known here: axes, band, length, rate, stream"),
        ("sed=1", "unknown key 'sed'; a setting of the model is config.NAME"),
        ("prepare.rate=-5", "prepare.rate"),
        ("prepare.band=[1000,20]", "prepare.band: band must be low < high in Hz, got 1000 20"),
        ("training.checkpoint_every=0", "training.checkpoint_every: must be greater than 0, got 0"),
        ("seed=many", "seed: must be a valid integer"),
    ],
)
def test_what_is_no_recipe_is_refused_in_one_line(file, change, message):
    with pytest.raises(ParameterError, match=message) as caught:
        Recipe.load(file, changes=parse_changes([change]))
    assert "\n" not in str(caught.value)


def test_a_value_is_no_table(file):
    with pytest.raises(ParameterError, match="seed is a value, not a table"):
        Recipe.load(file, changes={"seed": 1, "seed.x": 2})


def test_broken_toml_names_the_file(tmp_path):
    (tmp_path / "x.toml").write_text("model = ")
    with pytest.raises(DataError, match="x.toml: not readable as TOML"):
        Recipe.load(tmp_path / "x.toml")


def test_run_id_sees_every_value_and_the_data():
    recipe = Recipe(model="m").model_dump(mode="json")
    ids = {run_id(recipe, "a"), run_id(recipe, "b"), run_id(recipe | {"seed": 1}, "a")}
    assert len(ids) == 3
    assert all(len(i) == 10 for i in ids)


@pytest.mark.parametrize(
    ("prepare", "rate"),
    [
        ({}, 44100),
        ({"band": (20, 1000)}, 44100),
        ({"band": (20, 1000), "rate": "band"}, 2500),
        ({"rate": 500}, 500),
    ],
)
def test_the_rate_follows_the_recipe(prepare, rate):
    t = np.arange(44100) / 44100
    signal = Signal(np.sin(2 * np.pi * 100 * t), 44100, "1")
    prepared = Preparation(**prepare).apply(signal)
    assert prepared.rate == rate
    middle = prepared.samples[0, len(prepared) // 4 : -len(prepared) // 4]
    assert np.sqrt(np.mean(middle**2)) == pytest.approx(np.sqrt(0.5), rel=0.01)


def test_acceleration_is_the_default_stream_then_the_first():
    assert Preparation().stream_of(["force", "acceleration"]) == "acceleration"
    assert Preparation().stream_of(["pac", "tdc"]) == "pac"
    assert Preparation(stream="tdc").stream_of(["pac", "tdc"]) == "tdc"
    with pytest.raises(ParameterError, match="prepare.stream must be one of pac, tdc, got 'x'"):
        Preparation(stream="x").stream_of(["pac", "tdc"])
    for preparation in (Preparation(), Preparation(stream="x")):
        with pytest.raises(ParameterError, match="there are no recordings"):
            preparation.stream_of([])


def test_the_beginning_is_kept_where_takes_end_at_rest():
    signal = Signal(np.arange(500.0), 100, "m/s^2")
    assert Preparation(length=2.5).apply(signal).samples[0, -1] == 249
    assert len(Preparation(length=9).apply(signal)) == 500
    along = Signal(np.arange(500.0), 40, "1", domain="displacement")
    assert Preparation(length=10).apply(along).length_mm == 10
    with pytest.raises(ParameterError, match="length"):
        Recipe.of({"model": "stroke_cnn", "prepare": {"length": 0}})


def test_axes_are_chosen_or_combined():
    signal = Signal(np.random.default_rng(0).standard_normal((3, 500)), 1000, "m/s^2")
    assert Preparation(axes=("y",)).apply(signal).axes == ("y",)
    one = Preparation(axes="dft321").apply(signal)
    assert len(one.axes) == 1
    assert (one.samples**2).sum() == pytest.approx((signal.samples**2).sum(), rel=1e-4)


def test_mean_of_axes_is_one_axis_however_many_there_were():
    two = Signal(np.array([[1.0, 3.0], [3.0, -1.0]]), 100.0, "1", ("left", "right"))
    mixed = Preparation(axes="mean").apply(two)
    assert mixed.axes == Preparation(axes="mean").apply(two.select("left")).axes == ("mean",)
    np.testing.assert_array_equal(mixed.samples, [[2.0, 1.0]])
