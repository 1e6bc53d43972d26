"""What goes wrong is one line, leaves nothing behind, and can be gone on from."""

import tempfile
from dataclasses import replace

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Recording, create_store, open_store
from tactogram.datasets.simulate.sets import SETS
from tactogram.errors import ParameterError, RunError
from tactogram.signal.io import write_signal
from tactogram.signal.resampling import resample
from tactogram.training.run import Run
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.data.stores import add_signal
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.surface_index import SurfaceIndex
from tactogram.workflows.training.train import train


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accelerator": "nothing"}, "accelerator nothing"),
        ({"devices": 0}, "devices must be >= 1, got 0"),
        ({"where": {"material": "cork"}}, "at least 2 materials"),
        ({"changes": {"prepare.axes": ["q"]}}, "axis must be one of x, y, z"),
        ({"changes": {"prepare.axes": []}}, "prepare.axes.*at least 1 item"),
        ({"changes": {"prepare.rate": 1e12}}, "prepare.rate.*must be less than or equal to 1000000"),
        (
            {"changes": {"config.steps": 10**19}},
            "config of stroke_cnn: steps: must be at most 10000000, got 1000",
        ),
        ({"changes": {"config.filters": [10**10, 8]}}, "filters: must be at most 10000000"),
        ({"changes": {"config.window": 5000}}, "a window needs 5000"),
        ({"changes": {"config.pool": 64}}, "too short for these filters"),
        ({"changes": {"config.filters": [0, 8]}}, "filters.0"),
        ({"changes": {"config.filters": []}}, "filters"),
        ({"changes": {"config.batch_size": 1}}, "batch_size"),
        ({"changes": {"config.learning_rate": float("inf")}}, "learning_rate"),
        ({"split": "last=50"}, "must have more than 50 recordings, got 10"),
        ({"split": "last=-1"}, "needs a number of recordings"),
        ({"split": "last=2", "by": "session"}, "cannot keep sessions together"),
    ],
)
def test_a_training_that_cannot_begin_leaves_nothing(options, message, store, tmp_path):
    with pytest.raises(ParameterError, match=message) as raised:
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", **{"accelerator": "cpu", **options})
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "run").exists()


def test_a_network_larger_than_memory_is_refused(store, tmp_path, monkeypatch):
    monkeypatch.setattr("torch.nn.Linear.reset_parameters", lambda layer: None)  # which takes a minute first
    changes = {"config.dense": [10**7, 10**7]}
    with pytest.raises(ParameterError, match="model stroke_cnn needs more memory than there is"):
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", changes=changes, accelerator="cpu")
    assert not (tmp_path / "run").exists()


def test_settings_that_are_refused_leave_no_prepared_folder(store, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(ParameterError, match="axis must be one of x, y, z"):
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", changes={"prepare.axes": ["q"]})
    assert list(tmp_path.glob("tactogram-prepared-*")) == []


def test_a_training_that_fails_in_its_first_step_leaves_nothing(store, tmp_path, monkeypatch):
    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}

    def failed(*args, **kwargs):
        raise MemoryError("unable to allocate 74 GiB")

    monkeypatch.setattr("tactogram.training.loop.fit", failed)
    with pytest.raises(
        ParameterError, match=r"stroke_cnn needs more memory than there is \(unable to allocate"
    ):
        train("stroke_cnn", store, **options)
    assert not (tmp_path / "run").exists()


def test_a_run_keeps_every_value_of_its_model(run):
    assert run.recipe.config["hop"] == 0.5
    assert run.recipe.config["steps"] == 60


def test_a_run_counts_as_finished_only_when_it_can_be_searched(store, tmp_path, monkeypatch, texture):
    made = {}

    def killed(self, *args, **kwargs):
        made["index"] = (self.folder / "search.json").is_file()
        raise KeyboardInterrupt

    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}
    monkeypatch.setattr(Run, "finish", killed)
    with pytest.raises(KeyboardInterrupt):
        train("stroke_cnn", store, **options)
    monkeypatch.undo()
    assert made["index"]
    assert not Run.open(tmp_path / "run").finished
    finished = train("stroke_cnn", store, resume=True, **options)
    assert classify(finished.folder, texture("cork", 5))["none_of_these"] in (True, False)


def test_a_run_has_its_split_as_soon_as_it_is_one(store, tmp_path, monkeypatch):
    def killed(*args, **kwargs):
        raise KeyboardInterrupt

    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}
    monkeypatch.setattr(Run, "create", killed)
    with pytest.raises(KeyboardInterrupt):
        train("stroke_cnn", store, **options)
    monkeypatch.undo()
    assert not (tmp_path / "run" / "recipe.toml").exists()
    assert train("stroke_cnn", store, **options).finished


def test_folds_that_test_nothing_are_refused(store, tmp_path):
    for options, message in (
        ({"split": "all"}, "keeps nothing for testing"),
        ({"only_folds": 0}, "only_folds must be greater than or equal to 1"),
        ({"only_folds": -1}, "only_folds must be greater than or equal to 1"),
    ):
        with pytest.raises(ParameterError, match=message):
            crossval("stroke_cnn", store, recipe="tiny", folds=2, out=tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_search_embeds_only_what_is_new(run, store, texture, recordings, tmp_path, monkeypatch):
    copy = tmp_path / "store"
    create_store(copy, recordings(count=2), name="textures", licence="made in a test", simulated=True)
    signal = texture("foam", 321)
    (run.folder / "search-embedded.npz").unlink(missing_ok=True)  # of other tests' searches
    loaded = load_run(run.folder)
    embedded = []
    embed = loaded.model.embed
    monkeypatch.setattr(loaded.model, "embed", lambda s: embedded.append(1) or embed(s))
    before = search(loaded, signal, data=copy)
    first = len(embedded)
    write_signal(tmp_path / "new.wav", signal)
    added = add_signal(copy, tmp_path / "new.wav", material="felt")
    found = search(loaded, signal, data=copy)
    assert first >= 8 + 1
    assert len(embedded) - first == 2  # what is searched for, and what was added
    assert found["nearest"][0] == {
        "id": added["id"],
        "material": "felt",
        "distance": pytest.approx(0, abs=1e-5),
    }
    assert found["threshold"] == SurfaceIndex.load(run).threshold
    assert before["nearest"][0]["material"] != "felt"
    (run.folder / "search-embedded.npz").write_bytes(b"PK\x03\x04 broken")
    assert search(loaded, signal, data=copy)["nearest"][0]["id"] == added["id"]
    (run.folder / "search-embedded.npz").unlink()


def test_search_wants_a_count(run, texture):
    with pytest.raises(ParameterError, match="count must be at least 1"):
        search(run.folder, texture("foam", 1), count=0)


@pytest.mark.parametrize(
    "name", ["search-vectors.npy", "search-whitening.npy", "model.safetensors", "model.json", "data.json"]
)
def test_a_broken_run_is_refused_in_one_line(run, store, texture, tmp_path, name):
    export_run(run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "run")
    (tmp_path / "run" / name).write_bytes(b"[1, 2]")
    with pytest.raises(RunError, match=name) as raised:
        search(tmp_path / "run", texture("foam", 1), data=store)
    assert "\n" not in str(raised.value)


def test_weights_of_another_network_are_refused(run, tmp_path):
    export_run(run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "run")
    recipe = tmp_path / "run" / "recipe.toml"
    recipe.write_text(recipe.read_text().replace("window = 32", "window = 48"))
    with pytest.raises(RunError, match="weights do not fit the recipe"):
        load_run(tmp_path / "run")


def test_other_data_is_brought_to_the_rate_of_the_training(run, texture, tmp_path):
    faster = (
        Recording(streams={"acceleration": resample(texture(name, 900 + i), 660.0)}, material=name)
        for name in ("cork", "foam", "tile")
        for i in range(2)
    )
    create_store(tmp_path / "faster", faster, name="faster", licence="made in a test")
    assert evaluate(run.folder, data=tmp_path / "faster")["recording_accuracy"] >= 0.5


def test_an_evaluation_without_a_search_index_has_no_verdict(run, tmp_path):
    export_run(run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "run")
    (tmp_path / "run" / "search.json").unlink()
    assert "none_of_these" not in evaluate(tmp_path / "run")


def test_what_is_added_stays_simulated(texture, tmp_path):
    real = Recording(streams={"acceleration": texture("cork", 1)}, material="cork")
    create_store(tmp_path / "store", [real], name="real", licence="made in a test")
    write_signal(tmp_path / "made.wav", texture("foam", 2), metadata={"simulated": "true"})
    assert not open_store(tmp_path / "store").simulated
    with pytest.raises(ParameterError, match="speed_mm_s must be a finite number"):
        add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam", speed_mm_s=np.nan)
    with pytest.raises(ParameterError, match="force_n must be greater than or equal to 0, got -3"):
        add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam", force_n=-3.0)
    added = add_signal(tmp_path / "store", tmp_path / "made.wav", material="foam")
    bigger = open_store(tmp_path / "store")
    assert bigger.info(added["id"]).simulated
    assert bigger.simulated


def test_a_store_that_fails_its_check_exits_1(recordings, tmp_path, capsys):
    create_store(tmp_path / "store", recordings(count=1), name="x", licence="made in a test")
    assert main(["data", "check", str(tmp_path / "store")]) == 0
    shard = next((tmp_path / "store").glob("shard-*.parquet"))
    shard.write_bytes(shard.read_bytes()[:-1] + b"\0")
    assert main(["data", "check", str(tmp_path / "store"), "--json"]) == 1
    said = capsys.readouterr()
    assert "Traceback" not in said.err


def test_what_the_system_refuses_is_one_line(run, store, tmp_path, capsys):
    (tmp_path / "file").touch()
    for arguments in (
        ["run", "export", str(run.folder), "--out", str(tmp_path / "file" / "run.zip")],
        ["crossval", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--out", str(tmp_path / "file")],
        ["train", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--out", str(tmp_path / "file")],
        ["generate", str(run.folder), "--material", "cork", "--seed", "-1", "--out", str(tmp_path / "x.wav")],
    ):
        assert main(arguments) == 1
        [*_, last] = capsys.readouterr().err.strip().split("\n")
        assert last.startswith("tactogram: ")


@pytest.fixture
def few_surfaces(monkeypatch):
    """Two of the nine: each takes most of a second to make."""
    nine = SETS["stroking9"]
    monkeypatch.setitem(SETS, "stroking9", replace(nine, surfaces=nine.surfaces[1:3]))


@pytest.mark.usefixtures("few_surfaces")
def test_a_simulated_store_says_the_command_that_makes_it(tmp_path):
    options = {"seed": 3, "per_class": 1, "seconds": 0.5, "rate": 500.0}
    with pytest.raises(ParameterError, match="workers must be greater than or equal to 1"):
        simulate_to_store("stroking9", tmp_path / "store", workers=-1, **options)
    assert not (tmp_path / "store").exists()
    simulate_to_store("stroking9", tmp_path / "store", workers=1, **options)
    said = open_store(tmp_path / "store").facts.source
    assert said == "tactogram data simulate stroking9 --seed 3 --per-class 1 --seconds 0.5 --rate 500"


@pytest.mark.usefixtures("few_surfaces")
def test_a_simulated_set_takes_other_speeds_and_says_so(tmp_path):
    options = {"seed": 3, "per_class": 1, "seconds": 0.5, "workers": 1}
    simulate_to_store("stroking9", tmp_path / "store", speeds_mm_s=(50.0, 100.0), **options)
    store = open_store(tmp_path / "store")
    assert sorted({info.speed_mm_s for info in store.index}) == [50.0, 100.0]
    assert store.facts.source.endswith("--seconds 0.5 --speeds 50,100")
    for speeds, words in (((), "1 to 2000"), ((0.0,), "1 to 2000"), ((50.0, 50.0), "speeds must differ")):
        with pytest.raises(ParameterError, match=words):
            simulate_to_store("stroking9", tmp_path / "no", speeds_mm_s=speeds, **options)
    code = main(["data", "simulate", "stroking9", "--speeds", "fast", "--out", str(tmp_path / "no")])
    assert code == 1
    assert not (tmp_path / "no").exists()
