"""Models and the installation as they are shown."""

import json

import torch

from tactogram.cli import main


def test_a_model_is_shown_with_the_settings_of_a_training(capsys):
    assert main(["models", "stroke_cnn", "--recipe", "paper", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["settings"]["config.window"]["value"] == 200
    assert main(["models", "stroke_cnn"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "recipes: paper, quick, tiny" in lines
    assert any(line.split()[:2] == ["config.dropout", "0.5"] for line in lines)
    assert main(["models", "stroke_cn"]) == 1
    assert capsys.readouterr().err.endswith("did you mean 'stroke_cnn'?\n")


def test_doctor_tells_which_weights_are_missing_and_where_they_are_from(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / "vgg19-dcbb9e9d.pth").write_bytes(b"other bytes")
    assert main(["doctor"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("weights of")]
    assert len(lines) == 4
    assert (
        f"AlexNet (LPIPS): missing: {tmp_path}/checkpoints/alexnet-owt-7be5be79.pth, SHA-256 7be5be79"
        in lines[0]
    )
    assert "https://github.com/toshas/torch-fidelity" in lines[1]
    assert "another checksum" in lines[2]
