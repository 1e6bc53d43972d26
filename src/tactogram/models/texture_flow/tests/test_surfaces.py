import numpy as np
from scipy.signal import butter, sosfiltfilt, welch

from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.signal import Signal

RATE, SECONDS = 1000.0, 20


def noise(above_hz: float) -> Signal:
    white = np.random.default_rng(0).standard_normal((1, int(RATE * SECONDS)))
    filtered = sosfiltfilt(butter(4, above_hz, "highpass", fs=RATE, output="sos"), white)
    return Signal(filtered.astype(np.float32), RATE, "m/s^2", ("x",))


def gain_db(spectra: SurfaceSpectra, signal: Signal) -> float:
    """Return the gain at 1.2 bins that a signal has by encoding and decoding."""
    surface = spectra.measure([signal])
    coded = spectra.encode(signal.samples, surface)
    made = spectra.decode(coded, [surface], len(signal) - spectra.transform.n_fft, seed=0)
    low = 1.2 * RATE / spectra.transform.n_fft
    densities = []
    for samples in (made, signal.samples):
        hertz, density = welch(samples[0], RATE, nperseg=512)
        densities.append(density[np.abs(hertz - low) < 4].mean())
    return float(10 * np.log10(densities[0] / densities[1]))


def test_the_lowest_frequencies_are_as_strong_as_recorded():
    spectra, signal = SurfaceSpectra(Config(), RATE), noise(8.0)
    without = gain_db(spectra, signal)
    spectra.lowest = spectra.lowest_of([signal])
    assert spectra.lowest > 0.6
    assert abs(gain_db(spectra, signal)) < 1.5 < abs(without)


def test_recordings_with_nothing_below_the_first_bin_get_nothing_there():
    assert SurfaceSpectra(Config(), RATE).lowest_of([noise(30.0)]) == 0
