"""Evaluation of runs: of textures, and of friction over displacement as a finger meets it."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.cli import main
from tactogram.datasets import Recording, create_store
from tactogram.errors import LeakError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.signal.resampling import resample
from tactogram.workflows.data.convert import convert
from tactogram.workflows.evaluation import mixing_ladder as mixing
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.run_evaluation import evaluate_run
from tactogram.workflows.generation.generate import generate_files
from tactogram.workflows.training import loaded_run
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.train import train

RATE = 40.0  # per mm
POLES = {"denim": 0.9, "linen": 0.3, "satin": -0.4, "terry": -0.85}
HASTY = {"steps": 4, "most": 2}


def photograph(seed, size=96):
    return Image(np.random.default_rng(seed).integers(0, 256, (size, size, 3), dtype=np.uint8))


def friction(material, seed):
    x = lfilter([1], [1, -POLES[material]], np.random.default_rng(seed).standard_normal(2400))
    return Recording(
        streams={"friction": Signal(0.5 + 0.05 * x / x.std(), RATE, "1", ("along",), "displacement")},
        material=material,
        speed_mm_s=80.0,
        force_n=0.5,
        simulated=True,
    )


@pytest.fixture(scope="module")
def fabrics(tmp_path_factory):
    return create_store(
        tmp_path_factory.mktemp("fabrics") / "store",
        [friction(name, 100 * k + seed) for k, name in enumerate(POLES) for seed in range(8)],
        name="fabrics",
        licence="none",
        simulated=True,
        photographs=[(name, photograph(100 * k + n)) for k, name in enumerate(POLES) for n in range(10)],
    ).path


def trained(fabrics, out, **options):
    return train("frictgan", fabrics, recipe="tiny", out=out, accelerator="cpu", **options)


@pytest.fixture(scope="module")
def friction_run(fabrics, tmp_path_factory):
    return trained(fabrics, tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture(scope="module")
def figures(friction_run):
    return evaluate_run(friction_run.folder, evaluation=HASTY)[0]


def test_a_signal_over_displacement_is_written_with_its_length(friction_run, tmp_path):
    condition = {"image": photograph(1)}
    (row,) = generate_files(friction_run.folder, condition, tmp_path / "x.npz")
    signal = read_signal(tmp_path / "x.npz")
    assert (signal.domain, signal.length_mm, signal.rate) == (
        "displacement",
        row["length_mm"],
        row["rate_per_mm"],
    )
    (played,) = generate_files(
        friction_run.folder, condition | {"speed_mm_s": 50.0}, tmp_path / "y.wav", seconds=1.0
    )
    assert played["seconds"] == read_signal(tmp_path / "y.wav").seconds == 1.0


def test_is_judged_as_met_at_one_speed_though_recordings_have_a_force(figures):
    row = figures["measures"]["log_spectral_distance_db"]
    assert all(row[name] is not None for name in ("model", "floor", "ar_texture", "replay", "nearest_photo"))
    assert any("as met at 50 mm/s" in note for note in figures["notes"])
    assert row["replay"] < row["ceiling"]


def test_one_fabric_held_out_is_judged_without_the_published_figure(fabrics, tmp_path, capsys):
    by_material = trained(fabrics, tmp_path / "run", by="material")
    effort = ["--evaluation", "steps=4", "--evaluation", "most=2"]
    assert main(["evaluate", str(by_material.folder), *effort, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["as_published"] is None
    assert "two fabrics" in found["as_published_missing"]
    assert found["measures"]["log_spectral_distance_db"]["model"] is not None


def test_figures_that_are_no_numbers_are_null_in_json(friction_run, figures, monkeypatch):
    nothing = {"mean": {"mse": float("nan")}, "per_material": {"denim": {"mse": float("inf")}}}
    monkeypatch.setattr(
        "tactogram.workflows.evaluation.run_evaluation.evaluate_run",
        lambda *_, **__: (figures | {"as_published": nothing}, []),
    )
    found = evaluate(friction_run.folder, evaluation=HASTY)
    json.dumps(found, allow_nan=False)
    assert found["as_published"]["mean"]["mse"] is None
    assert "NaN" not in (friction_run.folder / "evaluation.json").read_text()


def test_what_a_model_refuses_in_its_first_step_leaves_nothing(fabrics, tmp_path):
    with pytest.raises(ParameterError, match="over displacement"):
        train("ar_texture", fabrics, recipe="tiny", out=tmp_path / "run", accelerator="cpu")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("speed", [0.0, -5.0, float("nan")])
def test_a_speed_that_is_none_is_called_a_speed(speed, tmp_path):
    write_signal(tmp_path / "x.npz", friction("denim", 1).streams["friction"])
    with pytest.raises(ParameterError, match="play_at must be"):
        convert(tmp_path / "x.npz", tmp_path / "y.wav", play_at=speed)
    assert not (tmp_path / "y.wav").exists()


def test_data_of_another_kind_is_named_and_refused(friction_run, tmp_path):
    signal = Signal(np.random.default_rng(3).standard_normal(3000), 1000.0, "m/s^2", ("along",))
    other = create_store(
        tmp_path / "other",
        [Recording(streams={"acceleration": signal}, material="denim")],
        name="other",
        licence="none",
        photographs=[("denim", photograph(999))],
    )
    with pytest.raises(ParameterError, match="other: not what run was trained on: signal must be"):
        evaluate_run(friction_run.folder, data=other.path, evaluation=HASTY)


@pytest.mark.parametrize("model", ["nearest_photo", "replay"])
def test_recorded_friction_is_played_from_its_run_too(fabrics, tmp_path, model):
    run = train(model, fabrics, recipe="tiny", out=tmp_path / "run", accelerator="cpu")
    found = evaluate_run(run.folder, evaluation=HASTY)[0]["measures"]["log_spectral_distance_db"]
    assert found["model"] < found["ceiling"]
    assert None not in (found["floor"], found["replay"])


NOWHERE = Path(__file__) / "made"
"""Beneath a file: not even root writes there."""


def test_nothing_is_judged_mixed_or_converted_for_a_folder_that_cannot_be_written(
    run, store, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        "tactogram.workflows.evaluation.run_evaluation.evaluate_run",
        lambda *_, **__: pytest.fail("judged all the same"),
    )
    monkeypatch.setattr(mixing, "mix_ladder", lambda *_, **__: pytest.fail("mixed all the same"))
    loaded = loaded_run.load_run(run.folder)
    with pytest.raises(ParameterError, match="cannot be written"):
        mixing.mixing_ladder(loaded, "cork", "tile", out=NOWHERE)
    unwritable = loaded_run.LoadedRun(
        type(run)(NOWHERE), loaded.facts, loaded.recipe, loaded.any_kind, loaded.model
    )
    with pytest.raises(ParameterError, match="cannot be written"):
        evaluate(unwritable)
    (tmp_path / "a.csv").write_text("x\n1\n2\n")
    with pytest.raises(ParameterError, match="cannot be written"):
        convert(tmp_path, NOWHERE, format="wav", rate=100.0)


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


def test_evaluation_names_split_and_floor(run):
    figures = evaluate(run.folder, unknown=True)
    assert figures["recording_accuracy"] >= 0.8
    assert figures["recordings"] == 6
    assert figures["none_of_these"]["unknown"] == 10
    assert figures["none_of_these"]["unknown_materials"] == ["wool"]
    assert 0 <= figures["none_of_these"]["auroc"] <= 1
    assert figures["data"]["simulated"] is True
    page = (run.folder / "report.html").read_text()
    assert "Simulated data" in page
    assert json.loads((run.folder / "evaluation.json").read_text()) == figures


def test_other_data_is_matched_by_name_and_what_was_trained_on_is_refused(run, store, tmp_path, recordings):
    create_store(
        tmp_path / "new", recordings(("tile", "cork"), 2, first=50), name="new", licence="-", simulated=True
    )
    figures = evaluate(run.folder, data=tmp_path / "new")
    assert figures["recordings"] == 4
    with pytest.raises(LeakError, match="of its 40 recordings were trained on"):
        evaluate(run.folder, data=store)
