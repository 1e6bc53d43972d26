import numpy as np
import pytest
from tests.rendering.files.documents import problems, written_by

from tactogram.errors import ParameterError
from tactogram.rendering.files import read_haptic, write_haptic
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.formats import hjif
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass
from tactogram.signal.resampling import resample


def band(document):
    return document["perceptions"][0]["channels"][0]["bands"][0]


def test_a_waveform_comes_back_with_its_level_unit_and_axes(tmp_path):
    signal = Signal(5 * np.random.default_rng(0).normal(size=(3, 500)), 3200, "m/s^2", ("a", "b", "c"))
    found = write_haptic(tmp_path / "x.hjif", signal, format="hjif", metadata={"simulated": True})
    file = read_haptic(tmp_path / "x.hjif")
    assert (file.signal.rate, file.signal.unit, file.signal.axes) == (3200, "m/s^2", ("a", "b", "c"))
    assert file.metadata == {"simulated": True}
    np.testing.assert_allclose(file.signal.samples, signal.samples, atol=1e-6 * found["full_scale"])
    assert found["loss"]["b"]["snr_db"] > 100
    assert file.facts["modality"] == "Acceleration"


@pytest.mark.parametrize("rate", [0.4, 42.0, 333.3, 999.5, 1000.0])
def test_slow_and_fractional_rates_come_back_exactly(tmp_path, rate):
    signal = Signal(np.sin(np.arange(50)), rate, "1")
    write_haptic(tmp_path / "x.hjif", signal, format="hjif")
    back = read_haptic(tmp_path / "x.hjif").signal
    assert (back.rate, len(back)) == (rate, 50)
    np.testing.assert_allclose(back.samples, signal.samples, atol=2e-3)


def test_friction_over_displacement_keeps_its_domain(tmp_path):
    signal = Signal(0.4 + 0.1 * np.sin(np.arange(200) / 5), 40, "1", ("along",), "displacement")
    write_haptic(tmp_path / "x.hjif", signal, format="hjif")
    file = read_haptic(tmp_path / "x.hjif")
    assert (file.signal.domain, file.signal.rate, file.signal.axes) == ("displacement", 40, ("along",))
    assert file.facts["modality"] == "Friction"
    np.testing.assert_allclose(file.signal.samples, signal.samples, atol=1e-6)


def test_modalities_can_be_asked_for(tmp_path):
    signal = Signal(np.zeros(9), 100, "1")
    write_haptic(tmp_path / "x.hjif", signal, format="hjif", modality="Vibrotactile Texture")
    assert read_haptic(tmp_path / "x.hjif").facts["modality"] == "Vibrotactile Texture"
    with pytest.raises(ParameterError, match="modality must be one of Other, Pressure"):
        write_haptic(tmp_path / "x.hjif", signal, format="hjif", modality="Texture")


def test_above_8_khz_a_signal_is_resampled_and_the_result_says_so(tmp_path):
    t = np.arange(44100) / 44100
    signal = Signal(0.9 * np.sin(2 * np.pi * 230 * t), 44100, "1")
    found = write_haptic(tmp_path / "x.hjif", signal, format="hjif")
    assert (found["resampled_to"], read_haptic(tmp_path / "x.hjif").signal.rate) == (8000, 8000)
    assert found["loss"]["waveform_correlation"] > 0.9999
    assert found["loss"]["snr_db"] > 50


def test_what_resampling_loses_is_not_felt(tmp_path):
    noise = Signal(0.2 * np.random.default_rng(1).normal(size=22050), 44100, "1")
    found = write_haptic(tmp_path / "x.hjif", noise, format="hjif")
    back = resample(read_haptic(tmp_path / "x.hjif").signal, 44100)
    # The ends are continued by a guess when resampled: noise does not follow it.
    felt, kept = (bandpass(x, 0, 1000).samples[:, 1000:-1000] for x in (noise, back))
    assert found["loss"]["snr_db"] < 3
    assert 10 * np.log10(np.mean(felt**2) / np.mean((felt - kept) ** 2)) > 60


def test_silence_costs_two_keyframes():
    document = written_by(hjif, Signal(np.zeros(8000), 8000, "1"))
    assert len(band(document)["effects"][0]["keyframes"]) == 2


def test_many_axes_need_level_2():
    document = written_by(
        hjif, Signal(np.zeros((130, 4)), 100, "1", tuple(map(str, range(130)))), DocumentHeader()
    )
    assert (document["level"], problems(hjif, document)) == (2, [])
