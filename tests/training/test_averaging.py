"""Several processes of one training: two CPU processes (gloo) against one."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from tests.training import adversarial_job


@pytest.mark.slow
def test_two_processes_have_the_losses_and_weights_of_one_with_twice_the_batch(tmp_path):
    """With a gradient penalty, clipping, two optimisers and weights that one process reaches."""
    job = [sys.executable, adversarial_job.__file__, tmp_path / "two.json"]
    subprocess.run(job, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"}, timeout=300)
    two = json.loads((tmp_path / "two.json").read_text(encoding="utf-8"))
    one = adversarial_job.train(1)
    for name in ("critic", "generator"):
        expected = [losses[name] for losses in one["losses"]]
        np.testing.assert_allclose([losses[name] for losses in two["losses"]], expected, rtol=1e-5, atol=1e-6)
    assert one["weights"]["unused"] == two["weights"]["unused"] == [1.0]
    assert one["weights"]["last"] != [1.0]
    for name, values in one["weights"].items():
        np.testing.assert_allclose(two["weights"][name], values, rtol=1e-6, atol=1e-9, err_msg=name)
