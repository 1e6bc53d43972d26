"""The simulated transducer: its current, its blocks, and no jump."""

import numpy as np
import pytest

from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.simulation import TransducerSimulation


def test_blocks_change_nothing():
    random = np.random.default_rng(1)
    v = random.uniform(0, 1, 500)
    whole = TransducerSimulation(PRESETS["finger"], rate=20_000, carrier_hz=28_180).process(v)
    one = TransducerSimulation(PRESETS["finger"], rate=20_000, carrier_hz=28_180)
    parts = [one.process(piece) for piece in np.split(v, [1, 7, 100, 333])]
    for k in (0, 1):
        np.testing.assert_allclose(np.concatenate([part[k] for part in parts]), whole[k], atol=1e-12)


def test_a_settled_carrier_draws_the_admittance():
    t = PRESETS["plate"]
    motional, whole = TransducerSimulation(t, rate=10_000, carrier_hz=28_230).process(np.full(2000, 2.0))
    assert whole[-1] / 2 == pytest.approx(complex(t.admittance(28_230)), rel=1e-6)
    assert motional[-1] / 2 == pytest.approx(complex(t.motional_admittance(28_230)), rel=1e-6)


def test_nothing_jumps_when_the_resonance_does():
    simulated = TransducerSimulation(PRESETS["plate"], rate=48_000, carrier_hz=28_200)
    before, _ = simulated.process(np.ones(4000))
    simulated.change(transducer=PRESETS["plate"].shifted(40))
    after, _ = simulated.process(np.ones(4000))
    assert abs(after[0] - before[-1]) < 0.02 * abs(before[-1])
    assert abs(after[-1]) < 0.8 * abs(before[-1])
