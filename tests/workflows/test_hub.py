"""The way to a server of the Hugging Face Hub and back."""

import json
import shutil

import pytest

from tactogram.cli import main
from tactogram.errors import RunError
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.training.export import export, import_from
from tactogram.workflows.training.loaded_run import load_run


@pytest.fixture(scope="module")
def evaluated(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "felt_cork"
    shutil.copytree(run.folder, folder)
    evaluate(folder)
    return folder


def test_pushed_to_a_server_and_pulled_it_is_the_run_again(evaluated, hub, tmp_path, capsys):
    out = str(tmp_path / "folder")
    words = ["run", "export", str(evaluated), "--to", "hub", "--out", out, "--push", "lab/felt", "--json"]
    assert main(words) == 0
    assert json.loads(capsys.readouterr().out)["pushed"].startswith(f"{hub.url}/lab/felt/commit/")
    weights = (evaluated / "model.safetensors").read_bytes()
    assert hub.repositories["lab/felt"]["model.safetensors"] == weights
    assert main(["run", "import", "hf://lab/felt", "--out", str(tmp_path / "again")]) == 0
    assert (tmp_path / "again" / "model.safetensors").read_bytes() == weights
    assert load_run(tmp_path / "again").kind == load_run(evaluated).kind


def test_a_refusing_server_is_one_line(evaluated, hub, monkeypatch, tmp_path):
    with pytest.raises(RunError, match="lab/none: the Hub did not do it: .*Repository Not Found"):
        import_from("hf://lab/none", out=tmp_path / "run")
    monkeypatch.setenv("HF_TOKEN", "hf_wrong")
    with pytest.raises(RunError, match=r"lab/felt: the Hub did not do it: .*401.*hf auth login"):
        export(evaluated, to="hub", out=tmp_path / "folder", push="lab/felt")
    assert not (tmp_path / "run").exists()
