"""What the page Touch plays: tables that hold what rendering plays, found in a workspace and never outside of it."""

import json
import struct

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.strength import strength
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import parameter_views
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import NoiseMap, TextureMap
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture, NoiseTable
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture, SurfaceTexture
from tactogram_studio.touch.tables import rounded_parameters, table_of_map, table_of_signal

RATE = 48_000.0


VOICES = "studio/first/voices"


BEYOND = [
    "recorded at 50 to 200 mm/s; slower strokes count as 50, faster ones as 200",
    "recorded with 0.3 to 1 N; lighter strokes count as 0.3, firmer ones as 1",
]


def resonance(hz, rms, rate=1000.0):
    polynomial = [1, -2 * 0.97 * np.cos(2 * np.pi * hz / rate), 0.97**2]
    flat = AutoregressiveModel.from_coefficients([polynomial], [1.0], rate=rate, unit="m/s^2")
    scale = rms**2 / flat.power[0]
    return AutoregressiveModel.from_coefficients([polynomial], [scale], rate=rate, unit="m/s^2")


@pytest.fixture(scope="module")
def surface():
    conditions = [(v, f) for v in (50.0, 100.0, 200.0) for f in (0.3, 1.0)]
    return TextureMap([resonance(1.5 * v, 1 + f) for v, f in conditions], conditions)


def ridges(per_mm=0.5, length_mm=80.0, rate=20.0, amplitude=2.0):
    place = np.arange(round(length_mm * rate)) / rate
    wave = amplitude * np.sin(2 * np.pi * per_mm * place)
    return Signal(wave[None].astype(np.float32), rate, "m/s^2", ("z",), domain="displacement")


def unpacked(data):
    """Return head and arrays as the browser reads them."""
    assert data[:4] == b"TGTT"
    (length,) = struct.unpack("<I", data[4:8])
    head = json.loads(data[8 : 8 + length])
    return head, {
        name: np.frombuffer(data, place["type"], place["length"], place["offset"])
        for name, place in head["arrays"].items()
    }


def test_a_packed_table_holds_the_models_that_rendering_plays(surface):
    head, arrays = unpacked(table_of_map("slope", surface, rate=RATE, simulated=True).packed())
    table = TextureTable(surface)
    texture = AutoregressiveTexture("slope", table, rate=RATE, most=128, seed=0)
    assert (head["kind"], head["order"], head["unit"], head["simulated"]) == (
        "autoregressive",
        2,
        "m/s^2",
        True,
    )
    assert np.array_equal(arrays["speeds"], table.grid.speeds)
    assert np.array_equal(arrays["reflection"], table.grid.reflection.ravel())
    assert np.array_equal(arrays["deviation"], table.grid.deviation.ravel())
    assert np.array_equal(arrays["kernel"], texture.resampler.kernel.ravel())
    assert (head["half"], head["table_rate"]) == (texture.resampler.half, 1000.0)
    assert head["follows"] == "speed and force"
    assert head["notes"] == BEYOND


@pytest.fixture(scope="module")
def noise():
    """Modulated noise of band 100 to 200 Hz whose rms is 1 + force, at three speeds, in two axes of equal strength."""
    section, random = butter(2, (100, 200), "bandpass", fs=1000, output="sos"), np.random.default_rng(0)
    models, conditions = [], [(v, f) for v in (50.0, 100.0, 200.0) for f in (0.3, 1.0)]
    for _, force in conditions:
        x = sosfilt(section, random.standard_normal((2, 6000)))
        models.append(fit_modulated_noise(Signal((1 + force) * x / x.std(), 1000.0, "m/s^2", ("x", "y"))))
    return NoiseMap(models, conditions)


@pytest.mark.slow
def test_a_packed_table_of_noise_holds_what_rendering_plays(noise):
    head, arrays = unpacked(table_of_map("noise", noise, rate=RATE, axes="y").packed())
    table = NoiseTable(noise, axis="y")
    texture = ModulatedNoiseTexture("noise", table, rate=RATE, most=128, seed=0)
    assert (head["kind"], head["lags"], head["table_rate"]) == ("noise", table.lags, 1000.0)
    whole, steps = rounded_parameters(table)
    curved = arrays["values"].reshape(whole.shape[::-1])
    assert np.array_equal(np.cumsum(np.cumsum(curved, axis=2), axis=2).T, whole)
    assert np.array_equal(arrays["steps"], steps)
    assert np.array_equal(arrays["speeds"], table.grid.speeds)
    assert np.array_equal(arrays["kernel"], texture.resampler.kernel.ravel())
    assert head["half"] == texture.resampler.half
    assert head["notes"] == [*BEYOND, "axis y only"]
    assert head["follows"] == "speed and force"


@pytest.mark.slow
def test_rounded_parameters_keep_the_spectrum_and_lengthen_no_vector(noise):
    table = NoiseTable(noise, axis="y")
    whole, steps = rounded_parameters(table)
    for exact, rounded in zip(
        table.grid.values.reshape(-1, len(steps)), (whole * steps).reshape(-1, len(steps)), strict=True
    ):
        (one, _), (other, _) = (
            parameter_views(np.float64(v), axes=1, lags=table.lags) for v in (exact, rounded)
        )
        power, changed = (np.abs(np.fft.rfft(each.taps[0])) ** 2 for each in (one, other))
        loud = power > 1e-3 * power.max()
        assert np.abs(10 * np.log10(changed[loud] / power[loud])).max() < 0.3
        assert np.abs(one.quantiles - other.quantiles).max() < 4e-3
        assert np.abs(one.rotations - other.rotations).max() < 0.01
        for s, k, t in other.rotations:
            assert np.linalg.norm(np.block([[s, k], [-k.T, t]]), 2) < 1 + 1e-12


def test_several_axes_are_refused(noise):
    with pytest.raises(ParameterError, match="must combine several axes into one, got 'all'"):
        table_of_map("noise", noise, rate=RATE, axes="all")


def test_a_phone_is_told_the_strength_of_noise_at_each_node(noise):
    """The amplitude of the sine with its power: all of it lies within the felt band."""
    table = table_of_map("noise", noise, rate=RATE, axes="x")
    amplitude = table.arrays["vibration"].reshape(len(table.arrays["speeds"]), -1)
    assert amplitude[0, 0] == pytest.approx(np.sqrt(2) * 1.3, rel=0.1)
    assert amplitude[-1, -1] == pytest.approx(np.sqrt(2) * 2.0, rel=0.1)


def test_every_array_begins_where_numbers_of_eight_bytes_may(surface):
    head, _ = unpacked(table_of_map("a name of odd length", surface, rate=44_100.0).packed())
    assert {place["offset"] % 8 for place in head["arrays"].values()} == {0}


def test_a_packed_surface_holds_the_copies_that_rendering_plays():
    signal = ridges()
    head, arrays = unpacked(table_of_signal("ridges", signal, rate=RATE, along="x").packed())
    texture = SurfaceTexture("ridges", signal, rate=RATE, along="x")
    assert np.allclose(arrays["nodes"], texture.nodes[:, 0].ravel(), atol=1e-6)
    assert (head["kind"], head["along"], head["copies"]) == ("surface", "x", len(texture.nodes))
    assert head["nodes_per_mm"] == pytest.approx(texture.nodes_per_mm)
    assert head["samples_per_speed"] == pytest.approx(texture.samples_per_speed)


def test_level_and_peak_are_those_under_a_simulated_hand():
    head = table_of_signal("ridges", ridges(amplitude=2.0), rate=RATE).head
    assert head["level"] == pytest.approx(2.0 / np.sqrt(2), rel=0.01)
    assert head["rms"] == pytest.approx(head["level"], rel=0.15)
    assert 2.0 <= head["peak"] < 12.0  # a landing on top: 4 times the level for each N


def test_twice_the_signal_is_twice_the_peak():
    peaks = [table_of_signal("r", ridges(amplitude=a), rate=RATE).head["peak"] for a in (0.01, 0.02)]
    assert peaks[1] == pytest.approx(2 * peaks[0], rel=1e-4)


def test_gravity_is_taken_out_and_axes_become_one():
    random = np.random.default_rng(0)
    shaking = random.normal(0, 1, (3, 4000)).astype(np.float32)
    heavy = shaking + np.float32([[0], [0], [9.81]])
    signals = [Signal(samples, 1000.0, "m/s^2", ("x", "y", "z")) for samples in (shaking, heavy)]
    light, loaded = (table_of_signal("s", signal, rate=RATE, speed_mm_s=100) for signal in signals)
    assert np.allclose(light.arrays["nodes"], loaded.arrays["nodes"], atol=1e-2)
    assert loaded.head["level"] == pytest.approx(np.sqrt(3), rel=0.1)
    assert "DFT321" in loaded.head["notes"][0]


def test_an_assumed_speed_is_said():
    signal = Signal(np.sin(np.arange(4000) / 5)[None].astype(np.float32), 1000.0, "1")
    assert "100 mm/s is assumed" in table_of_signal("s", signal, rate=RATE).head["notes"][0]
    assert table_of_signal("s", signal, rate=RATE, speed_mm_s=50).head["notes"] == []


def test_a_long_recording_is_cut_and_that_is_said():
    random = np.random.default_rng(0)
    signal = Signal(random.normal(0, 1, (1, 400_000)).astype(np.float32), 10_000.0, "m/s^2")
    table = table_of_signal("long", signal, rate=RATE, speed_mm_s=100)
    assert table.arrays["nodes"].size <= 4_000_000
    assert "too long to send" in table.head["notes"][-1]


def test_silence_is_refused():
    silent = Signal(np.full((1, 1000), 9.81, np.float32), 1000.0, "m/s^2")
    with pytest.raises(ParameterError, match="still is silent: there is nothing to feel"):
        table_of_signal("still", silent, rate=RATE, speed_mm_s=100)


def test_a_phone_is_told_the_strength_that_rendering_finds(surface):
    """The mean strength of ten seconds of noise at two nodes is the table's amplitude to 5 %."""
    table = table_of_map("slope", surface, rate=RATE)
    amplitude = table.arrays["vibration"].reshape(len(table.arrays["speeds"]), -1)
    phone = open_display("phone-on-off")
    for i in (0, -1):
        model = TextureTable(surface).at(table.arrays["speeds"][i], 1.0)
        signal = synthesise(model, 10.0, seed=1)
        found = strength(signal, phone.settings, display=phone, level=parse_level("gain=0.05")).share / 0.05
        assert np.sqrt(np.mean(found**2)) == pytest.approx(amplitude[i, -1], rel=0.05)


def test_a_surfaces_strength_goes_with_the_place():
    signal = ridges(per_mm=0.5, length_mm=200.0)
    half = signal.samples.copy()
    half[:, 2000:] *= 0.25
    head, arrays = unpacked(table_of_signal("half", signal.with_samples(half), rate=RATE).packed())
    place = np.arange(len(arrays["vibration"])) * head["vibration_step_mm"]
    # The loop begins a tenth of the length and more into the signal, where its end is joined on.
    assert arrays["vibration"][(place > 20) & (place < 60)] == pytest.approx(2.0, rel=0.06)
    assert arrays["vibration"][(place > 100) & (place < 140)] == pytest.approx(0.5, rel=0.06)
