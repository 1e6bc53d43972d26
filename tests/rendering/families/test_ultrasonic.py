import numpy as np
import pytest
from benchmarks.experiments.simulated_transducer import demodulated, simulate_envelope, simulate_waveform
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.families.ultrasonic import Settings, modulated
from tactogram.rendering.level import Level
from tactogram.signal import Signal
from tactogram_playback.transducer.circuit import Transducer


def tone(frequency, *, rate=8000, seconds=0.5, level=1.0, unit="m/s^2"):
    t = np.arange(round(rate * seconds)) / rate
    return Signal(level * np.sin(2 * np.pi * frequency * t), rate, unit)


def texture(seed=0, *, rate=4000, seconds=0.4, unit="m/s^2"):
    return Signal(np.random.default_rng(seed).standard_normal(round(rate * seconds)), rate, unit)


def amplitude(x, frequency, rate):
    x = x.astype(float)
    return 2 * abs(np.mean((x - x.mean()) * np.exp(-2j * np.pi * frequency * np.arange(len(x)) / rate)))


@pytest.mark.parametrize("name", ["ultrasonic", "ultrasonic-envelope"])
def test_a_shipped_display_has_the_numbers_of_hatori_and_takemura(name):
    """2023, Sec. III-C: a resonance of "≈ 28.2 kHz", "a gain factor of 10", "a maximum voltage of 22 V"."""
    display = open_display(name)
    s = display.settings
    assert (s.carrier_hz, s.amplifier_gain, s.limit_v) == (28_200, 10, 22)
    assert display.limit == pytest.approx(22 / 10 / 2)  # at the generator, if 22 V are peak to peak
    assert display.band == (0, 1000)  # Sec. IV-A: "frequencies from 1 to 1,000 Hz"


@pytest.mark.parametrize(("counts", "peak"), [("peak", 2.2), ("peak-to-peak", 1.1)])
def test_the_generator_gets_the_limit_over_the_gain(counts, peak):
    s = Settings(limit_is=counts, depth=0.6)
    drive, facts = modulated(tone(100), s, rate=500_000)
    assert facts["peak_v"] == pytest.approx(peak)
    assert facts["carrier_v"] == pytest.approx(peak / 1.6)
    assert np.abs(drive.samples).max() == pytest.approx(peak, rel=5e-3)


@settings(max_examples=60)
@given(
    seed=st.integers(0, 1000),
    depth=st.floats(0.05, 1),
    q=st.floats(10, 800),
    pre=st.booleans(),
    mapping=st.sampled_from(["vibration", "friction"]),
    output=st.sampled_from(["waveform", "envelope"]),
    limit=st.floats(0.01, 300),
    gain=st.floats(0.5, 50),
)
def test_no_drive_exceeds_its_limit(seed, depth, q, pre, mapping, output, limit, gain):
    s = Settings(
        depth=depth,
        q=q,
        pre_emphasis=pre,
        mapping=mapping,
        output=output,
        limit_v=limit,
        amplifier_gain=gain,
        carrier_hz=20_000,
    )
    rate = 48_000 if output == "waveform" else 6000
    drive, facts = modulated(texture(seed, seconds=0.1, unit="1"), s, rate=rate)
    assert np.abs(drive.samples.astype(float)).max() <= s.peak_v
    assert 2 * facts["highest_v"] * gain <= limit * (1 + 1e-9)
    if output == "envelope":
        assert drive.samples.min() >= 0


def test_without_pre_emphasis_a_tone_at_the_cutoff_falls_by_3_db():
    s = Settings(q=100, output="envelope", depth=0.5)
    drive, facts = modulated(tone(141), s, rate=48_000, fade_s=0)
    heard = simulate_envelope(Transducer(q=100), drive).samples[0][-9600:]
    assert facts["transducer"]["minus_3_db_hz"] == pytest.approx(141)
    assert facts["transducer"]["flat_to_hz"] == 0
    lost = 20 * np.log10(amplitude(heard, 141, 48_000) / (0.5 * facts["carrier_v"]))
    assert lost == pytest.approx(-3.01, abs=0.15)


def test_the_reported_depth_is_that_which_arrives():
    s = Settings(q=100, pre_emphasis=True, output="envelope")
    drive, facts = modulated(tone(500), s, rate=48_000, fade_s=0)
    heard = simulate_envelope(Transducer(q=100), drive).samples[0][-9600:]
    depth = amplitude(heard, 500, 48_000) / facts["carrier_v"]
    assert facts["recovered_depth"] == pytest.approx(depth, rel=0.02)
    assert facts["recovered_depth"] == pytest.approx(1 / abs(1 + 500j / 141), rel=0.07)


def test_more_than_full_scale_is_refused_with_how_much():
    x = tone(100, level=1.4)
    with pytest.raises(ParameterError, match=r"reaches 1\.4 of full modulation, .* lower the level"):
        modulated(x, Settings(output="envelope"), rate=16_000, full_scale=1.0)


def test_friction_is_least_where_the_amplitude_is_largest():
    mu = Signal(np.repeat([0.2, 0.5, 0.8, 0.2], 2000), 8000, "1")
    drive, facts = modulated(mu, Settings(mapping="friction", output="envelope"), rate=16_000, fade_s=0)
    middle = drive.samples[0][[2000, 6000, 10_000, 14_000]]
    np.testing.assert_allclose(middle / facts["peak_v"], [1, 0.5, 0, 1], atol=0.08)
    assert facts["friction_range"] == pytest.approx([0.2, 0.8])


def test_a_waveform_through_the_simulated_transducer_has_its_envelope():
    """Hatori & Takemura 2023, Sec. III-C: "inputting amplitude-modulated waves into the ultrasonic transducer"."""
    s = Settings(q=100, pre_emphasis=True)
    drive, _ = modulated(texture(), s, rate=500_000)
    e, _ = modulated(texture(), s.model_copy(update={"output": "envelope"}), rate=50_000)
    heard = demodulated(simulate_waveform(Transducer(q=100), drive), carrier_hz=28_200, band_hz=4000)
    wanted = simulate_envelope(Transducer(q=100), e)
    # Straight lines between the samples of 500 kHz lose 1 % of the carrier.
    np.testing.assert_allclose(heard.samples[0][::10], wanted.samples[0], atol=0.015 * wanted.samples.max())


def test_a_loop_has_no_seam():
    t = np.arange(4000) / 4000
    x = Signal(np.sin(2 * np.pi * 80 * t) + 0.5 * np.sin(2 * np.pi * 333 * t), 4000, "1")
    s = Settings(q=300, pre_emphasis=True, loop=True, output="envelope")
    drive, _ = modulated(x, s, rate=16_000)
    twice = np.concatenate([drive.samples[0], drive.samples[0]])
    seam = np.abs(np.diff(twice))[15_900:16_100].max()
    assert seam <= 1.05 * np.abs(np.diff(drive.samples[0]))[4000:12_000].max()


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"pre_emphasis": True}, "needs q"),
        ({"friction_range": (0.5, 0.2), "mapping": "friction"}, "smallest and largest"),
        ({"friction_range": (0.2, 0.5)}, "for the mapping friction"),
        ({"depth": 1.2}, "less than or equal to 1"),
        ({"volume": 3}, "Extra inputs"),
    ],
)
def test_settings_that_contradict_are_refused(change, match):
    with pytest.raises(ValidationError, match=match):
        Settings(**change)


def test_what_cannot_be_modulated_is_refused():
    with pytest.raises(ParameterError, match="needs a rate above"):
        modulated(tone(100), Settings(), rate=48_000)
    with pytest.raises(ParameterError, match="over displacement"):
        modulated(Signal(np.ones(10), 20, "1", domain="displacement"), Settings(), rate=500_000)
    with pytest.raises(UnitError, match="needs a friction coefficient"):
        modulated(tone(100), Settings(mapping="friction"), rate=500_000)
    with pytest.raises(ParameterError, match="throughout"):
        modulated(Signal(np.ones(100), 1000, "1"), Settings(mapping="friction"), rate=500_000)


@pytest.mark.parametrize("name", ["ultrasonic", "ultrasonic-envelope"])
def test_a_shipped_display_renders_three_axes_with_a_report(name):
    x = Signal(np.random.default_rng(0).standard_normal((3, 1000)), 2000, "m/s^2")
    drive = fit(x, open_display(name), level=Level("peak", 0.5))
    assert np.abs(drive.signal.samples).max() <= 1.1
    assert drive.report.as_json()["facts"]["transducer"]["flat_to_hz"] == pytest.approx(1000)
    assert any("pre-emphasis" in words for words in drive.report.scaled)


def test_a_level_that_nobody_measured_is_refused():
    with pytest.raises(UnitError, match="was not measured"):
        fit(tone(100), open_display("ultrasonic-envelope"), level=Level("physical"))


def test_a_gain_is_parts_of_full_modulation_per_unit():
    drive = fit(
        tone(40), open_display("ultrasonic-envelope", changes={"fade_ms": 0}), level=Level("gain", 0.25)
    )
    facts = drive.report.facts
    assert facts["full_scale"] == 4
    swing = np.ptp(drive.signal.samples[0][4000:-1000])
    assert swing == pytest.approx(2 * facts["carrier_v"] * 0.25 * np.hypot(1, 40 / 141), rel=0.01)


def test_a_limit_below_the_settings_is_refused():
    with pytest.raises(ParameterError, match=r"limit of 1 V is below the 1\.1 V"):
        fit(tone(100), open_display("ultrasonic-envelope", changes={"limit": 1.0}), level=Level("peak", 1.0))


def test_a_loop_is_rendered_without_a_fade():
    t = np.arange(2000) / 2000
    steady = Signal(np.cos(2 * np.pi * 100 * t).astype(np.float32), 2000, "1")
    looped = open_display("ultrasonic-envelope", changes={"ultrasonic.loop": True})
    drive = fit(steady, looped, level=Level("peak", 1.0))
    x = drive.signal.samples[0]
    # The end goes on with the beginning, and every period is as strong as the others.
    assert abs(x[-1] - x[0]) < 3 * np.abs(np.diff(x)).max()
    assert x[:160].max() == pytest.approx(x[8000:8160].max(), rel=1e-3)
    assert any("one period of a loop" in words for words in drive.report.scaled)


def test_inverted_friction_is_not_said_to_be_a_share_of_the_signal():
    t = np.arange(2000) / 2000
    mu = Signal((0.3 + 0.1 * np.sign(np.sin(2 * np.pi * 10 * t))).astype(np.float32), 2000, "1")
    rough = open_display("ultrasonic-envelope", changes={"ultrasonic.mapping": "friction"})
    scaled = fit(mu, rough, level=Level("peak", 1.0)).report.scaled
    assert not any("of the signal is full modulation" in words for words in scaled)
    assert any(words.startswith("the swing times 0.") for words in scaled)
