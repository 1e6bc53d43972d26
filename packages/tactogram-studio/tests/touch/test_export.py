"""The verb `touch` writes the document of a run's material or of a file, wherever it lies."""

import json

import pytest

from tactogram_studio.touch.document import texture_document
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.sources import TextureRequest

VOICES = "studio/first/voices"


def test_a_material_is_written_as_the_studio_saves_it(command, workspace, sources, tmp_path, monkeypatch):
    request = TextureRequest(where="run", of=VOICES, material="tile")
    expected = texture_document(sources.table(request), picture_of(sources, request))
    for folder, source in ((workspace, VOICES), (tmp_path, workspace / VOICES)):
        monkeypatch.chdir(folder)
        done = command("touch", source, "--material", "tile", "--out", tmp_path / "tile.json")
        assert done.returncode == 0, done.stderr
        assert "tile, simulated, " in done.stdout
        assert "follows the finger's path" in done.stdout
        assert json.loads((tmp_path / "tile.json").read_text(encoding="utf-8")) == json.loads(expected)


def test_a_file_is_laid_out_at_its_speed_and_that_is_in_the_facts(command, workspace, tmp_path):
    done = command("touch", workspace / "recordings/stroke.wav", "--out", tmp_path / "a.json", "--json")
    facts = json.loads(done.stdout)
    document = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert (facts["name"], facts["kind"], facts["simulated"]) == ("stroke", "surface", True)
    assert document["recorded_mm_s"] == 80
    assert facts["bytes"] == (tmp_path / "a.json").stat().st_size
    assert document["along"] == "path"
    amplitude = document["arrays"]["vibration"]["values"]
    assert len(amplitude) * document["vibration_step_mm"] == pytest.approx(document["length_mm"])
    command("touch", workspace / "recordings/stroke.wav", "--speed", 40, "--out", tmp_path / "b.json")
    assert json.loads((tmp_path / "b.json").read_text(encoding="utf-8"))["recorded_mm_s"] == 40


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([VOICES], "voices has no material ''; it has artificial-grass"),
        ([VOICES, "--material", "velvet"], "has no material 'velvet'"),
        (["recordings/none.wav"], "recordings/none.wav: no such file"),
        (["recordings"], "recordings: no such finished run"),
        (["recordings/stroke.wav", "--speed", "0"], "--speed must be"),
    ],
)
def test_what_is_no_texture_is_refused_in_a_line(
    command, workspace, tmp_path, monkeypatch, arguments, message
):
    monkeypatch.chdir(workspace)
    done = command("touch", *arguments, "--out", tmp_path / "no.json")
    assert done.returncode != 0
    assert message in done.stderr
    assert not (tmp_path / "no.json").exists()
