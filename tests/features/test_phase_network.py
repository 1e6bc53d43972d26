"""Phase recovery as a network: after a few steps, what the package recovers from the same phases."""

import math

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.features.amplitude_spectrogram import AmplitudeSpectrogram
from tactogram.features.phase import recover
from tactogram.features.phase_network import AmplitudePhaseRecovery, PhaseRecovery
from tactogram.features.stft import STFT
from tactogram.model import ExportedNetwork, Port

TRANSFORM, FRAMES = STFT(32, 8), 12
SPECTRUM = ("batch", "bin", "frame")


def phases(seed, bins, frames):
    return math.tau * torch.rand(1, bins, frames, generator=torch.Generator().manual_seed(seed))


def noise(seed, length):
    return torch.randn(1, length, generator=torch.Generator().manual_seed(seed))


def relative(network, draw, reference, folder):
    pytest.importorskip("onnxscript", reason="the extra export is not installed")
    from tactogram.workflows.training.onnx_export import export_network

    inputs = {"magnitude": Port(SPECTRUM, ""), "phase": Port(SPECTRUM, "", "rad")}
    outputs = {"signal": Port(("batch", "time"), "")}
    exported = ExportedNetwork(network.eval(), draw, inputs, outputs, free=(), reference=reference)
    return export_network(exported, folder / "phase.onnx")["difference"]["signal"]["relative"]


@pytest.mark.slow
def test_few_steps_are_those_of_the_package(tmp_path):
    def draw(seed):
        magnitude = TRANSFORM.forward(noise(seed, TRANSFORM.length(FRAMES))).abs()
        return 0.01 * magnitude, phases(seed, TRANSFORM.bins, FRAMES)

    def reference(magnitude, phase):
        return recover(magnitude, TRANSFORM, TRANSFORM.length(FRAMES), start=phase, iterations=6)

    assert relative(PhaseRecovery(TRANSFORM, FRAMES, 6), draw, reference, tmp_path) < 1e-5


@pytest.mark.parametrize("nonnegative", [True, False])
def test_few_steps_are_those_of_amplitude_spectrograms(nonnegative, tmp_path):
    spectrogram = AmplitudeSpectrogram(n_fft=32, hop=8, frames=FRAMES, iterations=3, nonnegative=nonnegative)

    def draw(seed):
        friction = noise(seed, spectrogram.length).abs()
        return spectrogram.encode(friction), phases(seed, spectrogram.bins, FRAMES)

    def reference(magnitude, phase):
        return spectrogram.decode(magnitude, phase=phase)

    assert relative(AmplitudePhaseRecovery(spectrogram), draw, reference, tmp_path) < 1e-5


def test_phases_that_are_given_are_those_of_a_seed():
    magnitude = TRANSFORM.forward(noise(0, TRANSFORM.length(FRAMES))).abs()
    random = torch.Generator().manual_seed(3)
    phase = math.tau * torch.rand(FRAMES, TRANSFORM.bins, generator=random, dtype=torch.float64)
    given, drawn = (
        recover(magnitude, TRANSFORM, TRANSFORM.length(FRAMES), start=start, iterations=4, seed=3)
        for start in (phase.mT[None], "random")
    )
    np.testing.assert_array_equal(given, drawn)
    with pytest.raises(ParameterError, match="phases to start from must have the shape of the magnitude"):
        recover(magnitude, TRANSFORM, TRANSFORM.length(FRAMES), start=phase[None])
