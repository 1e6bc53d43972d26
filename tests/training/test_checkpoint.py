import json

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from tactogram.errors import RunError
from tactogram.training import load_state, save_state


def test_a_state_comes_back_as_it_was(tmp_path):
    optimiser = torch.optim.Adam([torch.nn.Parameter(torch.ones(3))])
    optimiser.param_groups[0]["params"][0].grad = torch.ones(3)
    optimiser.step()
    state = {
        "a": {"w": torch.arange(4.0), 7: [1, 2.5, None, "x"]},
        "adam": optimiser.state_dict(),
        "n": np.float64(2),
    }
    save_state(tmp_path / "s.safetensors", state, {"step": 3})
    back, facts = load_state(tmp_path / "s.safetensors")
    assert facts == {"step": 3}
    assert torch.equal(back["a"]["w"], state["a"]["w"])
    assert back["a"][7] == [1, 2.5, None, "x"]
    assert back["n"] == 2.0
    optimiser.load_state_dict(back["adam"])
    assert optimiser.state_dict()["state"][0]["step"] == 1


def test_shared_and_strided_tensors_are_kept(tmp_path):
    whole = torch.arange(12.0).reshape(3, 4)
    save_state(tmp_path / "s.safetensors", {"t": whole.T, "row": whole[1], "whole": whole})
    back, _ = load_state(tmp_path / "s.safetensors")
    assert torch.equal(back["t"], whole.T)
    assert torch.equal(back["row"], whole[1])


def test_a_failed_write_leaves_the_old_one(tmp_path):
    path = tmp_path / "s.safetensors"
    save_state(path, {"a": 1})
    with pytest.raises(RunError, match="state at b must be a tensor or a JSON value, got object"):
        save_state(path, {"a": 2, "b": object()})
    assert load_state(path)[0] == {"a": 1}


@pytest.mark.parametrize("content", [b"", b"\x00" * 7, b"not a checkpoint at all, only text"])
def test_a_broken_file_is_refused(tmp_path, content):
    path = tmp_path / "s.safetensors"
    path.write_bytes(content)
    with pytest.raises(RunError, match="not a readable checkpoint"):
        load_state(path)


def test_a_file_that_lacks_a_tensor_is_refused(tmp_path):
    path = tmp_path / "s.safetensors"
    save_state(path, {"a": torch.ones(3), "b": torch.ones(3)})
    with safe_open(path, framework="pt") as file:
        save_file({"a": file.get_tensor("a")}, path, metadata=file.metadata())
    with pytest.raises(RunError, match="s.safetensors: damaged: lacks 'b'"):
        load_state(path)


def test_a_truncated_file_is_refused(tmp_path):
    path = tmp_path / "s.safetensors"
    save_state(path, {"a": torch.ones(100)})
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(RunError, match="not a readable checkpoint"):
        load_state(path)


def test_a_later_version_is_refused(tmp_path):
    from safetensors.torch import save_file

    header = json.dumps({"version": 99, "structure": {}, "facts": {}})
    save_file({"x": torch.ones(1)}, tmp_path / "s.safetensors", metadata={"tactogram": header})
    with pytest.raises(RunError, match="written by a later version"):
        load_state(tmp_path / "s.safetensors")
