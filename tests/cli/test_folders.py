"""Models in other folders."""

import json

from tactogram.cli import main


def test_a_model_from_another_folder_is_found_by_every_verb(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TACTOGRAM_MODELS", "")
    folder = tmp_path / "mine" / "my_model"
    folder.mkdir(parents=True)
    facts = 'title = "Mine"\nauthors = ["Me"]\nyear = 2026\n'
    facts += 'task = "generation"\nneeds = ["material"]\ngives = "signal"\n'
    (folder / "model.toml").write_text(facts)
    assert main(["models", "--models", str(tmp_path / "mine"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["my_model"]["title"] == "Mine"
