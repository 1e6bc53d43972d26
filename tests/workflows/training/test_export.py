"""A texture of a run as a C header: from the command line, and what is refused."""

import json

import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.workflows.training.export import export
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


def test_what_cannot_be_is_refused(run, textures, tmp_path):
    out = tmp_path / "texture.h"
    with pytest.raises(ParameterError, match="a C header needs a run of texture_var, this is stroke_cnn"):
        export(run.folder, to="c", out=out, material="cork")
    with pytest.raises(ParameterError, match="material must be one of cork, foam, tile, wool, got 'glass'"):
        export(textures.folder, to="c", out=out, material="glass")
    with pytest.raises(ParameterError, match="force_n is unknown"):
        export(textures.folder, to="c", out=out, material="cork", force=1.0)
    with pytest.raises(ParameterError, match="material must be omitted with to='onnx'"):
        export(textures.folder, to="onnx", out=out, material="cork")
    assert not out.exists()
