"""Files of published weights: found in torch's cache, checked, missing, and of something else."""

from hashlib import sha256
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from tactogram.errors import DataError
from tactogram.nn.weight_files import PretrainedWeights, read_weights, weight_file

CONTENT = b"some weights"
WEIGHTS = PretrainedWeights(
    "SomeNet", "a loss", f"https://example.org/somenet-{sha256(CONTENT).hexdigest()[:8]}.pth"
)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path / "hub"))
    WEIGHTS.cached.parent.mkdir(parents=True)
    return WEIGHTS.cached


def test_a_cached_file_is_told_by_its_checksum(cache):
    assert WEIGHTS.state() == "missing"
    cache.write_bytes(CONTENT)
    assert WEIGHTS.state() == "found"
    cache.write_bytes(CONTENT + b".")
    assert WEIGHTS.state() == "another checksum"


def test_the_file_is_the_one_named_or_the_cached_one(cache, tmp_path):
    own = tmp_path / "own.pth"
    with pytest.raises(DataError, match=r"own.pth: no weights of SomeNet there; set weights to somenet-"):
        weight_file(own, WEIGHTS, option="weights")
    with pytest.raises(
        DataError, match=r"weights of SomeNet \(a loss\) are missing: put somenet-.*\.pth into "
    ):
        weight_file("", WEIGHTS, option="weights")
    own.touch(), cache.touch()
    assert weight_file(own, WEIGHTS, option="weights") == own
    assert weight_file("", WEIGHTS, option="weights") == cache


def test_the_place_of_a_missing_file_names_no_ones_home(cache, tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    with pytest.raises(DataError, match=r"into ~/hub/checkpoints, from https://example.org/"):
        weight_file("", WEIGHTS, option="weights")


def test_tensors_are_read_by_name(tmp_path):
    tensors = {"a.weight": torch.arange(3.0)}
    torch.save(tensors, tmp_path / "w.pth")
    save_file(tensors, tmp_path / "w.safetensors")
    for name in ("w.pth", "w.safetensors"):
        torch.testing.assert_close(dict(read_weights(tmp_path / name)), tensors)


class Harmful:
    def __reduce__(self):
        return (print, ("ran",))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (Harmful(), "not a readable file of weights"),
        ([torch.zeros(1)], "not a file of weights: expected tensors by name"),
        ({"epoch": 3}, "not a file of weights: expected tensors by name"),
    ],
)
def test_a_file_of_something_else_is_refused_and_not_run(content, message, tmp_path, capsys):
    torch.save(content, tmp_path / "w.pth")
    with pytest.raises(DataError, match=f"w.pth: {message}") as error:
        read_weights(tmp_path / "w.pth")
    assert "\n" not in str(error.value)
    assert capsys.readouterr().out == ""
