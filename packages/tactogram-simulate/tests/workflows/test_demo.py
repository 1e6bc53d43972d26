import json
from dataclasses import replace
from functools import partial, wraps

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import RunError
from tactogram.signal import Image
from tactogram.workflows.training.train import train
from tactogram_simulate.sets import SETS
from tactogram_simulate.workflows import demo as module
from tactogram_simulate.workflows.demo import MIX, UNKNOWN, demo, photos_figure

KNOWN = ("artificial-grass", "cloth", *MIX)


@pytest.mark.slow
def test_the_whole_chain_leaves_a_report(tmp_path, monkeypatch, capsys):
    """Of five of the nine surfaces, each made once, in this process; the networks are small."""
    nine = SETS["stroking9"]
    five = tuple(surface for surface in nine.surfaces if surface.name in (*KNOWN, UNKNOWN))
    monkeypatch.setitem(SETS, "stroking9", replace(nine, surfaces=five))
    monkeypatch.setattr("tactogram.datasets.cores", lambda: 1)
    monkeypatch.setattr("tactogram.workflows.training.train.train", partial(train, recipe="tiny"))
    monkeypatch.setattr(module, "PER_CLASS", 8)
    monkeypatch.setattr(module, "GENERATOR_STEPS", 2)
    monkeypatch.setattr(module, "EVALUATION", {"steps": 20, "most": 4})
    result = {}
    kept = wraps(demo)(lambda *args, **options: result.update(demo(*args, **options)) or result)
    monkeypatch.setattr(module, "demo", kept)
    assert main(["demo", "--out", str(tmp_path / "demo")]) == 0
    said = capsys.readouterr().out
    assert str(tmp_path / "demo" / "report.html") in said
    assert f"recording accuracy {100 * result['recording_accuracy']:.1f} %" in said
    assert f"of {result['none_of_these']['unknown']} strokes over a surface absent from training" in said
    assert json.loads((tmp_path / "demo/result.json").read_text()) == json.loads(json.dumps(result))
    assert result["simulated"] is True
    assert result["recording_accuracy"] > 2 / len(KNOWN)
    row = result["measures"]["log_spectral_distance_db"]
    assert row["floor"] < row["replay"] < row["ceiling"]
    assert result["mixing"]
    page = (tmp_path / "demo" / "report.html").read_text(encoding="utf-8")
    assert "Simulated data" in page
    assert page.count("<audio") > 20
    assert len(list((tmp_path / "demo" / "sounds").glob("*.wav"))) == 5


def test_it_replaces_nothing_but_an_earlier_demo(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(RunError, match="is not an earlier demo"):
        demo(tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_photographs_are_drawn_under_their_names():
    photos = {f"surface {n}": Image(np.full((4, 6, 3), n, np.uint8)) for n in range(6)}
    axes = photos_figure(photos).axes
    assert [place.get_title() for place in axes] == [*photos, "", "", "", ""]
    assert [place.images[0].get_array().shape for place in axes[:6]] == [(4, 6, 3)] * 6
    assert not axes[9].images
