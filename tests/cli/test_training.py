"""What is printed of exported runs."""

import json

import pytest

from tactogram.cli import main
from tactogram.workflows.training.train import train


@pytest.fixture(scope="module")
def textures(store, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "var"
    by_speed = {"label": "material", "accelerator": "cpu"}
    return train("texture_var", store, recipe="tiny", changes={"prepare.rate": 1000.0}, out=out, **by_speed)


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


def test_the_command_tells_the_largest_difference(run, tmp_path, capsys):
    assert main(["run", "export", str(run.folder), "--to", "onnx", "--out", str(tmp_path / "networks")]) == 0
    text = capsys.readouterr().out
    assert "largest difference" in text
    assert "classifier.onnx" in text
    assert {p.name for p in (tmp_path / "networks").iterdir()} == {"classifier.onnx", "classifier.json"}
