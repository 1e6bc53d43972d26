"""Textures of a stream: pitch by speed, gratings, loops and friction."""

import math

import numpy as np
import pytest
from quiet_engine import engine, peak_hz
from scipy import signal as dsp
from seams import seam_excess_db

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.texture_map import TextureMap
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture, SurfaceTexture, looped

RATE, MOST = 8000.0, 40


@pytest.mark.parametrize("rate", [2500.0, 10_000.0])
def test_a_texture_at_another_rate_keeps_pitch_and_level(resonance, script, rendered, rate):
    table = TextureTable(TextureMap([resonance(300, rms=2.0, rate=rate)], [[100.0, math.nan]]))
    texture = AutoregressiveTexture("a", table, rate=RATE, most=MOST, seed=3)
    samples, _ = rendered(engine([texture], script(lambda t: 100 * t)), 6.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(300, abs=8)
    assert samples[0, 4000:].std() == pytest.approx(2.0, rel=0.15)
    assert 0 < texture.delay_s <= 0.005


def grating(cycles_per_mm=2.0, length_mm=50.0, rate=40.0, unit="m/s^2"):
    x = np.arange(int(length_mm * rate)) / rate
    return Signal(np.sin(2 * np.pi * cycles_per_mm * x).astype(np.float32), rate, unit, domain="displacement")


@pytest.mark.parametrize("speed", [50.0, 120.0, 300.0])
def test_a_grating_is_felt_at_its_cycles_by_the_speed(script, rendered, speed):
    surface = SurfaceTexture("grating", grating(), rate=RATE)
    samples, _ = rendered(engine([surface], script(lambda t: speed * t)), 3.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(2 * speed, abs=4)
    assert samples[0, 8000:].std() == pytest.approx(np.sqrt(0.5), rel=0.02)


def test_a_signal_over_time_is_laid_out_by_its_speed(script, rendered):
    t = np.arange(4000) / 2000
    made = Signal(np.sin(2 * np.pi * 150 * t).astype(np.float32), 2000, "m/s^2")
    surface = SurfaceTexture("a", made, rate=RATE, speed_mm_s=100.0)
    samples, _ = rendered(engine([surface], script(lambda t: 200 * t)), 2.0)
    assert peak_hz(samples[0, 4000:]) == pytest.approx(300, abs=4)
    with pytest.raises(ParameterError, match="over time; state the speed .* with `speed_mm_s`"):
        SurfaceTexture("a", made, rate=RATE)


def test_what_a_fast_finger_would_fold_back_is_gone(script, rendered):
    """15 cycles per mm at 400 mm/s are 6 kHz: above half of 8 kHz, to be folded to 2 kHz."""
    surface = SurfaceTexture("fine", grating(15.0), rate=RATE)
    samples, _ = rendered(engine([surface], script(lambda t: 400 * t)), 1.0)
    assert samples[0, 4000:].std() < 1e-3


def test_a_loop_has_no_seam():
    random = np.random.default_rng(1)
    rough = dsp.sosfilt(dsp.butter(4, 0.2, output="sos"), random.standard_normal(3000))
    loop = looped(Signal(rough.astype(np.float32), 40, "1", domain="displacement"))
    twice = Signal(np.tile(loop.samples, 4), 40, "1", domain="displacement")
    assert seam_excess_db(twice, [len(loop), 2 * len(loop), 3 * len(loop)]) < 3
    assert loop.samples.std() == pytest.approx(rough.std(), rel=0.1)


def test_a_period_begins_at_position_0(script, rendered):
    """A bump at 20 mm of 50 mm, which a loop would move."""
    x = np.arange(2000) / 40
    bump = Signal(np.exp(-((x - 20) ** 2) / 2).astype(np.float32), 40, "m/s^2", domain="displacement")
    surface = SurfaceTexture("bump", bump, rate=RATE, along="x", periodic=True)
    assert surface.length_mm == 50
    samples, _ = rendered(engine([surface], script(lambda t: 50 * t)), 1.0)
    assert 50 * np.argmax(samples[0]) / RATE == pytest.approx(20, abs=1)
    assert len(SurfaceTexture("bump", bump, rate=RATE, along="x").loop) < len(bump)


def test_friction_is_locked_to_the_place_and_holds_at_rest(script, rendered):
    """There and back over a ramp of friction coefficients: the same place has the same value."""
    x = np.arange(4000) / 40
    bump = 0.3 + 0.2 * np.exp(-((x - 50) ** 2) / 50)
    surface = SurfaceTexture(
        "bump", Signal(bump.astype(np.float32), 40, "1", domain="displacement"), rate=RATE, along="x"
    )
    moving = engine([surface], script(lambda t: 45 + 20 * math.sin(math.pi * t)))
    values, places = [], []
    for block in range(400):
        out = moving.render(block * MOST / RATE)[0]
        values.append(float(out[-1]))
        places.append(moving.tracker.block.x_mm[MOST - 1])
    loop = looped(Signal(bump.astype(np.float32), 40, "1", domain="displacement"))
    expected = np.interp(np.array(places) % loop.length_mm, np.arange(len(loop)) / 40, loop.samples[0])
    assert np.abs(np.array(values) - expected)[40:].max() < 2e-3
    still = engine([surface], script(lambda t: 45.0))
    samples, _ = rendered(still, 0.5)
    assert samples[0, -2000:].min() > 0.25


def test_textures_of_two_units_do_not_mix(texture, script):
    friction = SurfaceTexture("mu", grating(unit="1"), rate=RATE)
    with pytest.raises(ParameterError, match="one unit and number of axes"):
        engine([texture(), friction], script(lambda t: 0.0))
