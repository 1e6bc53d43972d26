"""Stimuli as a browser gets them."""

import io

import numpy as np
import soundfile

from tactogram.signal import Signal
from tactogram_study.participants.prepared_stimuli import wav_bytes


def test_a_drive_is_sent_to_the_last_bit():
    samples = np.random.default_rng(0).standard_normal((2, 480)).astype(np.float32)
    read, rate = soundfile.read(
        io.BytesIO(wav_bytes(Signal(samples, 48_000.0, "V", ("left", "right")))), dtype="float32"
    )
    assert rate == 48_000
    np.testing.assert_array_equal(read.T, samples)
