"""Taps and landings."""

import math

import numpy as np
import pytest
from quiet_engine import engine

from tactogram.rendering.motion.finger_state import Tap
from tactogram_playback.streaming.contact import ActiveTransients, ContactSettings

RATE, MOST = 8000.0, 40


def test_a_landing_is_heard_in_the_block_after_it(texture, script, rendered):
    moving = engine(
        [texture()], script(lambda t: 0.0, lambda t: 0.0 if t < 0.5 else 1.0), contact=ContactSettings()
    )
    samples, _ = rendered(moving, 1.0)
    begin = int(np.argmax(np.abs(samples[0]) > 1e-3 * np.abs(samples[0]).max()))
    assert 0 <= begin / RATE - 0.5 <= MOST / RATE
    assert np.abs(samples).max() == pytest.approx(4.0 * moving.textures[0].level, rel=0.05)
    assert moving.transients.started == 1


def test_a_tap_message_needs_no_contact(texture, script):
    class Tapped(script):
        def poll(self, now_s):
            return [*super().poll(now_s), *([Tap(now_s, 0.5)] if now_s == 0.25 else [])]

    moving = engine([texture()], Tapped(lambda t: 0.0, lambda t: 0.0), contact=ContactSettings())
    peaks = [np.abs(moving.render(b * MOST / RATE)).max() for b in range(60)]
    assert max(peaks[:50]) == 0
    assert peaks[50] > 0
    assert moving.latency.tap.count == 1


def test_a_transient_is_the_decaying_sine_of_its_settings():
    settings = ContactSettings(frequency_hz=200, decay_s=0.01, gain=2.0)
    transients = ActiveTransients(settings, RATE)
    transients.start(1.5, 1.0)
    whole = np.zeros((1, 800), np.float32)
    transients.add(whole, 800)
    t = np.arange(800) / RATE
    shape = np.exp(-t / 0.01) * np.sin(2 * np.pi * 200 * t)
    assert np.allclose(whole[0], 3.0 * shape / math.exp(-0.25 / 2), atol=1e-4)
    assert not transients._amplitude.any()
