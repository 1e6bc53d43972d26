"""Runs as C headers and ONNX files: what is written beside them, what is printed, and what is refused."""

import json

import numpy as np
import onnxruntime
import pytest
import torch

from tactogram.cli import main
from tactogram.datasets import create_store
from tactogram.errors import ParameterError, RunError
from tactogram.signal import Signal
from tactogram.workflows.training import export as module
from tactogram.workflows.training.export import export
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train


@pytest.fixture(scope="module")
def textures(recordings, tmp_path_factory):
    folder = tmp_path_factory.mktemp("textures")
    create_store(folder / "store", recordings(count=4), name="t", licence="made in a test", simulated=True)
    by_speed = {"label": "material", "accelerator": "cpu", "changes": {"prepare.rate": 1000.0}}
    return train("texture_var", folder / "store", recipe="tiny", out=folder / "run", **by_speed)


def test_the_header_says_of_what_it_is_and_what_it_costs(textures, tmp_path, capsys):
    file = tmp_path / "cork.h"
    words = ["run", "export", str(textures.folder), "--to", "c", "--material", "cork", "--speed", "150"]
    assert main([*words, "--out", str(file), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    text = file.read_text(encoding="utf-8")
    assert "Material cork" in text
    assert "150 mm/s" in text
    assert "simulated" in text
    assert "static void cork_block(cork_state *s, cork_real *out)" in text
    assert facts["usual"]["multiplications"] > 5 * 512
    assert f"{facts['dearest']['multiplications']}, " in text


def test_what_cannot_be_is_refused(run, textures, tmp_path):
    out = tmp_path / "texture.h"
    with pytest.raises(ParameterError, match="a C header needs a run of texture_var, this is stroke_cnn"):
        export(run.folder, to="c", out=out, material="cork")
    with pytest.raises(ParameterError, match="material must be one of cork, foam, tile, wool, got 'glass'"):
        export(textures.folder, to="c", out=out, material="glass")
    with pytest.raises(ParameterError, match="the suffix of a header, but to='zip'; give `to=c`"):
        export(textures.folder, out=out)
    with pytest.raises(ParameterError, match="force_n is unknown"):
        export(textures.folder, to="c", out=out, material="cork", force=1.0)
    with pytest.raises(ParameterError, match="material must be omitted with to='onnx'"):
        export(textures.folder, to="onnx", out=out, material="cork")
    assert not out.exists()


@pytest.fixture(scope="module", autouse=True)
def traced_once():
    """Trace a single time the one network that is exported here."""
    trace, programs = torch.onnx.export, []

    def traced(*args, **options):
        programs[:] = programs or [trace(*args, **options)]
        return programs[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(torch.onnx, "export", traced)
        yield


@pytest.fixture(scope="module")
def exported(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("onnx") / "networks"
    return folder, export(run.folder, to="onnx", out=folder)["networks"]["classifier"]


def windows(run, count=8):
    config = load_run(run.folder).config
    x = np.random.default_rng(0).standard_normal((count, len(run.kind().axes), config.window))
    return x.astype(np.float32)


def test_the_file_gives_what_the_run_gives_for_a_signal(run, exported):
    folder, described = exported
    loaded = load_run(run.folder)
    x = windows(run)
    session = onnxruntime.InferenceSession(str(folder / described["file"]))
    probability, embedding = session.run(None, {"windows": x})
    for k, window in enumerate(x):
        signal = Signal(window, run.kind().rate, run.kind().unit, run.kind().axes)
        np.testing.assert_allclose(probability[k], loaded.classifier.probabilities(signal), atol=1e-5)
        np.testing.assert_allclose(embedding[k], loaded.embedder.embed(signal), atol=1e-4)


def test_the_file_beside_it_says_what_goes_in_and_comes_out(run, exported):
    folder, described = exported
    kind = run.kind()
    assert json.loads((folder / "classifier.json").read_text(encoding="utf-8")) == described
    (entry,) = described["inputs"]
    assert entry["axes"] == ["batch", "axis", "time"]
    assert entry["shape"][0] is None
    assert (entry["unit"], described["rate_hz"]) == (kind.unit, kind.rate)
    assert described["material"] == list(kind.materials)
    assert described["simulated"] is True
    assert described["opset"] == 18


def test_the_command_tells_the_largest_difference(run, tmp_path, capsys):
    assert main(["run", "export", str(run.folder), "--to", "onnx", "--out", str(tmp_path / "networks")]) == 0
    text = capsys.readouterr().out
    assert "largest difference" in text
    assert "classifier.onnx" in text
    assert {p.name for p in (tmp_path / "networks").iterdir()} == {"classifier.onnx", "classifier.json"}


def test_a_network_that_computes_something_else_is_refused(run, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "MOST_DIFFERENCE", 0.0)
    with pytest.raises(RunError, match="cannot be exported: .* differs in onnxruntime by"):
        export(run.folder, to="onnx", out=tmp_path / "networks")
    assert not (tmp_path / "networks").exists()


def test_what_cannot_be_a_network_is_refused(run, store, tmp_path):
    textures = train("ar_texture", store, recipe="tiny", out=tmp_path / "ar", accelerator="cpu")
    with pytest.raises(ParameterError, match="has no networks to export"):
        export(textures.folder, to="onnx", out=tmp_path / "networks")
    assert not (tmp_path / "networks").exists()
    with pytest.raises(ParameterError, match="material must be omitted with to='onnx'"):
        export(run.folder, to="onnx", out=tmp_path / "networks", material="cork")
    (tmp_path / "there").mkdir()
    with pytest.raises(RunError, match="exists already"):
        export(run.folder, to="onnx", out=tmp_path / "there")
