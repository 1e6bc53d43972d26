"""Several processes of one training: two CPU processes (gloo) against one."""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from tactogram.errors import ParameterError
from tactogram.model import WHOLE_BATCH, BatchShare
from tactogram.nn.synchronised_batch_norm import SynchronisedBatchNorm, synchronise
from tactogram.training.processes import ALONE, devices_and_nodes
from tactogram.workflows.progress import silent
from tactogram.workflows.training.launch import in_processes

sys.path.insert(0, str(Path(__file__).parent))  # new processes import the job by name, too
adversarial_job = import_module("adversarial_job")


@pytest.fixture(scope="module")
def two():
    return in_processes(adversarial_job.train, {"devices": 2}, count=2, progress=silent, stop=lambda: False)


@pytest.mark.slow
def test_two_processes_have_the_losses_and_weights_of_one_with_twice_the_batch(two):
    """With batch normalisation, a gradient penalty, clipping, two optimisers and weights that one process reaches."""
    one = adversarial_job.train(1)
    for name in ("critic", "generator"):
        expected = [losses[name] for losses in one["losses"]]
        np.testing.assert_allclose([losses[name] for losses in two["losses"]], expected, rtol=1e-5, atol=1e-6)
    assert one["weights"]["unused"] == two["weights"]["unused"] == [1.0]
    assert one["weights"]["last"] != [1.0]
    for name, values in one["weights"].items():
        np.testing.assert_allclose(two["weights"][name], values, rtol=1e-6, atol=1e-9, err_msg=name)


def test_processes_agree(two):
    assert (two["agreed"], two["on_machine"], two["any"], two["none"]) == (0, 0, True, False)
    assert "the weights of the processes have diverged after a stage" in two["diverged"]


def test_one_process_agrees_with_itself():
    assert adversarial_job.agreements(ALONE) == {
        "agreed": 0, "on_machine": 0, "any": True, "none": False, "diverged": ""
    }  # fmt: skip


def test_shares_are_disjoint_and_whole():
    places = np.arange(24)  # three batches of eight
    shares = [BatchShare(number, 4).places(places, 8) for number in range(4)]
    np.testing.assert_array_equal(shares[1], [2, 3, 10, 11, 18, 19])
    np.testing.assert_array_equal(np.sort(np.concatenate(shares)), places)
    np.testing.assert_array_equal(WHOLE_BATCH.places(places, 8), places)
    with pytest.raises(
        ParameterError, match="must be a multiple of the 4 processes that share a batch, got 10"
    ):
        BatchShare(0, 4).size(10)


def test_synchronised_normalisation_alone_is_torchs():
    torch.manual_seed(0)
    plain = nn.Sequential(nn.Conv1d(2, 3, 3), nn.BatchNorm1d(3), nn.Sequential(nn.BatchNorm1d(3)))
    weights = list(plain.parameters())
    x = torch.randn(4, 2, 9)
    expected, state = plain(x), {k: v.clone() for k, v in plain.state_dict().items()}
    for name in ("1", "2.0"):
        plain.get_submodule(name).reset_running_stats()
    synchronise(plain)
    assert all(a is b for a, b in zip(weights, plain.parameters(), strict=True))
    assert isinstance(plain[1], SynchronisedBatchNorm)
    assert isinstance(plain[2][0], SynchronisedBatchNorm)
    torch.testing.assert_close(plain(x), expected)
    torch.testing.assert_close(plain.state_dict(), state)


@pytest.fixture
def group(tmp_path):
    """A group of this process alone."""
    torch.distributed.init_process_group("gloo", f"file://{tmp_path / 'group'}", rank=0, world_size=1)
    yield
    torch.distributed.destroy_process_group()


@pytest.mark.parametrize("affine", [True, False])
def test_synchronised_normalisation_of_a_group_is_torchs_and_can_be_differentiated_twice(group, affine):
    drawn = torch.Generator().manual_seed(0)
    x = (3 + torch.randn(6, 4, 5, generator=drawn, dtype=torch.float64)).requires_grad_()
    plain, synchronised = (
        kind(4, affine=affine, dtype=torch.float64) for kind in (nn.BatchNorm1d, SynchronisedBatchNorm)
    )
    found = []
    for norm in (plain, synchronised):
        y = norm(x)
        (slope,) = torch.autograd.grad((y**3).sum(), x, create_graph=True)
        (once,) = torch.autograd.grad((norm(x) ** 3).sum(), x)
        (twice,) = torch.autograd.grad(slope.square().sum(), x)
        found.append((y, slope, once, twice, norm.running_mean, norm.running_var))
    for expected, got in zip(*found, strict=True):
        torch.testing.assert_close(got, expected)


def test_torchruns_numbers_count(monkeypatch):
    assert devices_and_nodes(2, 3) == (2, 3)
    for name, value in {"TORCHELASTIC_RUN_ID": "1", "WORLD_SIZE": "6", "LOCAL_WORLD_SIZE": "2"}.items():
        monkeypatch.setenv(name, value)
    assert devices_and_nodes(1, 1) == devices_and_nodes(2, 3) == (2, 3)
    with pytest.raises(ParameterError, match="must be 2 and 3, as torchrun started, got 3 and 2; omit them"):
        devices_and_nodes(3, 2)
    with pytest.raises(ParameterError, match="must be >= 1, got 0 and 1"):
        devices_and_nodes(0, 1)
