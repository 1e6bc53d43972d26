"""Several processes of one training: two CPU processes (gloo) against one."""

import json
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import WHOLE_BATCH, BatchShare
from tactogram.training.processes import ALONE, devices_and_nodes

sys.path.insert(0, str(Path(__file__).parent))  # new processes import the job by name, too
adversarial_job = import_module("adversarial_job")


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    out = tmp_path_factory.mktemp("two") / "found.json"
    started = (sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2")
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run([*started, adversarial_job.__file__, out], check=True, env=environment, timeout=300)
    return json.loads(out.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_two_processes_have_the_losses_and_weights_of_one_with_twice_the_batch(two):
    """With a gradient penalty, clipping, two optimisers and weights that one process reaches."""
    one = adversarial_job.train(1)
    for name in ("critic", "generator"):
        expected = [losses[name] for losses in one["losses"]]
        np.testing.assert_allclose([losses[name] for losses in two["losses"]], expected, rtol=1e-5, atol=1e-6)
    assert one["weights"]["unused"] == two["weights"]["unused"] == [1.0]
    assert one["weights"]["last"] != [1.0]
    for name, values in one["weights"].items():
        np.testing.assert_allclose(two["weights"][name], values, rtol=1e-6, atol=1e-9, err_msg=name)


@pytest.mark.slow
def test_processes_agree(two):
    assert (two["agreed"], two["on_machine"], two["any"], two["none"]) == (0, 0, True, False)


def test_one_process_agrees_with_itself():
    assert adversarial_job.agreements(ALONE) == {"agreed": 0, "on_machine": 0, "any": True, "none": False}


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


def test_torchruns_numbers_count(monkeypatch):
    assert devices_and_nodes(2, 1) == (2, 1)
    for name, value in {"TORCHELASTIC_RUN_ID": "1", "WORLD_SIZE": "6", "LOCAL_WORLD_SIZE": "2"}.items():
        monkeypatch.setenv(name, value)
    assert devices_and_nodes(1, 1) == devices_and_nodes(2, 3) == (2, 3)
    with pytest.raises(ParameterError, match="must be 2 and 3, as torchrun started, got 3 and 2; omit them"):
        devices_and_nodes(3, 2)
    with pytest.raises(ParameterError, match="must be >= 1, got 0 and 1"):
        devices_and_nodes(0, 1)
