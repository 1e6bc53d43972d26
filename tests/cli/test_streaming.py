"""What the verb `stream` prints."""

import json

import pytest

from tactogram.cli import main
from tactogram.datasets import create_store
from tactogram.workflows.training.train import train


@pytest.fixture(scope="module")
def textures(recordings, tmp_path_factory):
    """An `ar_texture` of four made-up materials at two speeds, three axes."""
    folder = tmp_path_factory.mktemp("stream")
    create_store(folder / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    return train("ar_texture", folder / "store", recipe="tiny", split="all", out=folder / "run").folder


def test_the_verb_prints_a_table_and_json(textures, capsys, tmp_path):
    arguments = ["stream", str(textures), "--mix", "cork=1", "--backend", "file", "--seconds", "0.5"]
    assert main(arguments) == 0
    assert "underruns: 0" in capsys.readouterr().out
    displayed = ["--display", "voice-coil", "--level", "gain=0.5", "--set", "limit=2"]
    displayed += ["--set", "linear.equalise=none"]
    assert main([*arguments, *displayed, "--json"]) == 0
    told = capsys.readouterr()
    assert "equaliser: none, the response of voice-coil is not equalised" in told.err
    result = json.loads(told.out)
    assert result["latency"]["block_ms"] == 5.0
    assert (result["display"]["limit"], result["display"]["equaliser"]["on"]) == (2.0, False)
    assert main([*arguments, "--motion", str(tmp_path / "none.csv")]) == 1
    assert "none.csv" in capsys.readouterr().err
