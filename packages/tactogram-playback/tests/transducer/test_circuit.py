import numpy as np
import pytest
from benchmarks.experiments.simulated_transducer import demodulated, simulate_envelope, simulate_waveform
from hypothesis import given, settings, strategies as st

from tactogram.errors import DataError, ParameterError, UnitError
from tactogram.signal import Signal
from tactogram_playback.transducer.circuit import PRESETS, Transducer, fitted_transducer, read_sweep

# L1 mH, C1 pF, f_p Hz, k_eff, M, maximum of |Y| below f_s in Hz, envelope's cut-off in Hz: by formula.
TABLE = {
    "free": (90.3, 352.7, 29480, 0.291, 74, -0.24, 17.6),
    "free_high_r": (225.8, 141.1, 28719, 0.189, 30, -0.6, 17.6),
    "plate": (169.3, 188.1, 28890, 0.217, 15, -3.2, 47),
    "finger": (169.3, 188.1, 28890, 0.217, 5, -27, 141),
    "damped": (135.5, 235.2, 29059, 0.241, 1.9, -200, 470),
}


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_has_the_constants_of_its_circuit(name):
    t, (l1, c1, f_p, k, m, offset, cutoff) = PRESETS[name], TABLE[name]
    f = np.arange(27_900, 28_300, 0.02)
    highest = f[np.abs(t.admittance(f)).argmax()]
    assert t.l1_henry == pytest.approx(l1 * 1e-3, rel=1e-3)
    assert t.c1_farad == pytest.approx(c1 * 1e-12, rel=1e-3)
    assert t.antiresonance_hz == pytest.approx(f_p, abs=1)
    assert t.coupling == pytest.approx(k, abs=5e-4)
    assert t.q * t.c1_farad / t.c0_farad == pytest.approx(m, rel=0.03)
    assert highest - t.resonance_hz == pytest.approx(offset, rel=0.05)
    assert t.envelope_cutoff_hz == pytest.approx(cutoff, rel=0.005)


def sidebands_response(t, frequency, carrier_hz):
    """Return the mean of the upper and the conjugate lower sideband, each relative to the carrier."""
    middle, upper, lower = (t.motional_admittance(carrier_hz + f) for f in (0, frequency, -frequency))
    return (upper / middle + np.conj(lower / middle)) / 2


@pytest.mark.parametrize("q", [14, 30, 100, 300, 800])
def test_the_envelope_filter_is_the_mean_of_two_sidebands(q):
    t, f = Transducer(q=q), np.geomspace(5, 1000, 60)
    np.testing.assert_allclose(
        np.abs(t.envelope_response(f)), np.abs(sidebands_response(t, f, t.resonance_hz)), atol=3e-4
    )


def test_conductance_is_largest_at_resonance():
    f = np.arange(28_000, 28_400, 0.5)
    assert f[PRESETS["finger"].admittance(f).real.argmax()] == pytest.approx(28_200, abs=0.5)


@settings(max_examples=30)
@given(
    q=st.floats(20, 900),
    r1=st.floats(15, 900),
    resonance=st.floats(27_900, 28_500),
)
def test_a_sweep_gives_its_transducer_back(q, r1, resonance):
    t = Transducer(resonance, q, r1)
    f = np.linspace(27_400, 29_000, 161)
    found = fitted_transducer(f, t.admittance(f))
    assert found.resonance_hz == pytest.approx(resonance, abs=0.05)
    assert (found.q, found.r1_ohm) == (pytest.approx(q, rel=1e-3), pytest.approx(r1, rel=1e-3))
    assert found.c0_farad == pytest.approx(t.c0_farad, rel=1e-3)


def test_a_noisy_sweep_gives_q_within_percents():
    t, random = PRESETS["finger"], np.random.default_rng(0)
    f = np.linspace(27_400, 29_000, 81)
    noise = 1 + 0.01 * (random.standard_normal(81) + 1j * random.standard_normal(81))
    found = fitted_transducer(f, t.admittance(f) * noise)
    assert found.q == pytest.approx(100, rel=0.02)
    assert found.resonance_hz == pytest.approx(28_200, abs=1)


def test_a_sweep_beside_the_resonance_is_refused():
    f = np.linspace(25_000, 26_000, 50)
    with pytest.raises(ParameterError, match="no resonance from 25000 to 26000 Hz"):
        fitted_transducer(f, PRESETS["plate"].admittance(f))


@pytest.mark.parametrize("change", [{"q": 0.4}, {"r1_ohm": 0}, {"resonance_hz": np.inf}, {"c0_farad": -1e-9}])
def test_a_transducer_that_cannot_be_is_refused(change):
    with pytest.raises(ParameterError, match=f"{next(iter(change))} must be >"):
        Transducer(**change)


def test_a_sweep_is_read_and_a_bad_line_named(tmp_path):
    good = tmp_path / "sweep.csv"
    good.write_text("frequency_hz,conductance_s,susceptance_s\n28000,0.001,0.0007\n28200,0.01,0.0007\n")
    f, y = read_sweep(good)
    assert f.tolist() == [28000, 28200]
    assert y[1] == 0.01 + 0.0007j
    log = ("1,sweep", "2,lock", "3,lost", "4,sweep", "5,sweep", "6,lock", "7,track", "8,sweep")
    lines = (f"{line},0.01,0.001" for line in log)
    good.write_text("\n".join(["frequency_hz,state,conductance_s,susceptance_s", *lines]))
    assert read_sweep(good)[0].tolist() == [4, 5]
    good.write_text("frequency_hz,conductance_s,susceptance_s\n28000,x,0.0007\n")
    with pytest.raises(DataError, match=r"sweep.csv, line 2: needs three numbers"):
        read_sweep(good)
    with pytest.raises(DataError, match="none.csv: no such file"):
        read_sweep(tmp_path / "none.csv")


def envelope(frequency, *, rate=96_000, seconds=0.4, depth=0.5):
    t = np.arange(int(rate * seconds)) / rate
    return Signal(1 + depth * np.sin(2 * np.pi * frequency * t), rate, "V")


def line(x, frequency, rate):
    """Return the amplitude of a component in the last 0.2 s, a whole number of its periods."""
    x = x[-round(0.2 * rate) :].astype(float)
    return 2 * abs(np.mean(x * np.exp(-2j * np.pi * frequency * np.arange(len(x)) / rate)))


@pytest.mark.parametrize("q", [30, 100, 300])
@pytest.mark.parametrize("frequency", [20, 100, 400, 1000])
def test_over_time_the_envelope_falls_as_over_frequency(q, frequency):
    t = Transducer(q=q)
    x = simulate_envelope(t, envelope(frequency))
    wanted = 0.5 * abs(t.envelope_response(frequency))
    assert line(x.samples[0], frequency, x.rate) == pytest.approx(wanted, rel=2e-3)
    assert x.samples[0, -19_200:].mean(dtype=float) == pytest.approx(1, abs=2e-3)


def test_beside_the_resonance_both_sidebands_count():
    t = Transducer(q=300)
    x = simulate_envelope(t, envelope(60, depth=0.01), carrier_hz=28_230)
    middle = abs(t.motional_admittance(28_230)) * t.r1_ohm
    wanted = 0.01 * middle * abs(sidebands_response(t, 60, 28_230))
    assert x.samples[0, -19_200:].mean(dtype=float) == pytest.approx(middle, rel=2e-3)
    assert line(x.samples[0], 60, x.rate) == pytest.approx(wanted, rel=5e-3)


def test_a_waveform_comes_back_as_its_envelope_does():
    t = Transducer(q=100)
    e = envelope(200, rate=1_000_000, seconds=0.1)
    carrier = np.sin(2 * np.pi * 28_200 * np.arange(len(e)) / e.rate)
    heard = demodulated(
        simulate_waveform(t, e.with_samples(e.samples * carrier)), carrier_hz=28_200, band_hz=4000
    )
    np.testing.assert_allclose(
        heard.samples[0, 20_000:-20_000], simulate_envelope(t, e).samples[0, 20_000:-20_000], atol=4e-3
    )


def test_a_drive_not_in_volts_is_refused():
    with pytest.raises(UnitError, match=r"must be in V, got m/s\^2"):
        simulate_envelope(PRESETS["free"], Signal(np.ones(10), 1000, "m/s^2"))
    with pytest.raises(ParameterError, match="simulate its envelope instead"):
        simulate_waveform(PRESETS["free"], Signal(np.ones(10), 48_000, "V"))


def test_a_frequency_that_was_measured_twice_is_no_width_of_nothing():
    t = Transducer()
    f = np.repeat(np.linspace(t.resonance_hz - 600, t.resonance_hz + 600, 41), 2)
    assert fitted_transducer(f, t.admittance(f)).resonance_hz == pytest.approx(t.resonance_hz, abs=0.1)
    with pytest.raises(ParameterError, match="needs 8 frequencies"):
        fitted_transducer(np.full(20, 28e3), np.full(20, 1e-3 + 0j))
    with pytest.raises(ParameterError, match="must be 1 to 1e9 Hz, and its values finite"):
        fitted_transducer(np.where(np.arange(82) == 3, 1e-308, f), t.admittance(f))
