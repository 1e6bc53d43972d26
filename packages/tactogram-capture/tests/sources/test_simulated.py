"""Simulated sensors: losses in their place, and given signals measured."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram_capture import SourceEnded, open_source
from tactogram_capture.twelite.simulator import SimulatedPort, SimulatedReceiver, transmissions
from tactogram_capture.twelite.source import TweliteSource


def drained(source):
    blocks = []
    with source:
        while True:
            try:
                block = source.read(1.0)
            except SourceEnded:
                return blocks
            if block is not None:
                blocks.append(block)


def test_simulated_sensor_at_330_hz_arrives_with_its_losses_in_place():
    receiver = SimulatedReceiver(seconds=1, loss=0.1, seed=8)
    source = TweliteSource(SimulatedPort(receiver), name="simulated:twelite", simulated=True)
    blocks = drained(source)
    samples = np.concatenate([b.samples for b in blocks], axis=1)
    sent = list(transmissions(receiver))

    for block, index in zip(blocks, np.cumsum([0, *(len(b) for b in blocks)]), strict=False):
        assert block.first_index == index
    for one in sent:
        piece = samples[:, 10 * one.sequence : 10 * one.sequence + 10]
        assert np.isnan(piece).all() if not one.data else (piece == one.samples).all()
    facts = source.facts()
    assert facts["lost_packets"] == sum(not one.data for one in sent[: samples.shape[1] // 10]) > 0
    assert facts["simulated"] is True
    assert facts["rate"]["hz"] == pytest.approx(330, rel=0.02)


def test_a_simulated_sensor_measures_the_given_signal():
    times = np.arange(990) / 330
    x = np.stack([2 * np.sin(2 * np.pi * 50 * times), 0 * times, np.full_like(times, 9.81)])
    receiver = SimulatedReceiver()
    port = SimulatedPort(receiver, Signal(x.astype(np.float32), 330.0, "m/s^2"), paced=False)
    source = TweliteSource(port, name="simulated:twelite", simulated=True)
    samples = np.concatenate([b.samples for b in drained(source)], axis=1)

    # Steps of 4 mg: half of one is 0.02 m/s^2.
    assert samples == pytest.approx(x, abs=0.0197)


def test_a_recording_in_a_file_is_measured_and_one_of_another_kind_refused(tmp_path):
    x = np.random.default_rng(0).standard_normal((3, 660)).astype(np.float32)
    write_signal(tmp_path / "felt.csv", Signal(x, 330.0, "m/s^2"))
    write_signal(tmp_path / "force.csv", Signal(x[:1], 330.0, "N"))
    blocks = drained(open_source(f"simulated:twelite?file={tmp_path / 'felt.csv'}&paced=false"))

    assert np.concatenate([b.samples for b in blocks], axis=1) == pytest.approx(x, abs=0.0197)
    with pytest.raises(ParameterError, match=r"3 axes over time in m/s\^2, got 1 in N over time"):
        open_source(f"simulated:twelite?file={tmp_path / 'force.csv'}")
