"""
Autoregressive textures: fit, mix and stream
============================================

Fit an autoregressive model to each of two surfaces (here simulated: a resonance and broadband noise), mix them into one
that was never recorded, and stream from one to the other block by block: spectrum and level change smoothly, without a
click.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import lfilter, welch

from tactogram.signal import Signal
from tactogram.signal.autoregressive import mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import Synthesizer, synthesise

RATE = 2000.0

# %%
# Simulated recordings, m/s^2
# ---------------------------

rng = np.random.default_rng(0)


def recorded(poles, level):
    """Return 5 s of noise through a filter with ``poles`` (and their conjugates), at an rms ``level``."""
    polynomial = np.poly(np.concatenate([poles, np.conj(poles)])).real
    x = lfilter([1], polynomial, rng.standard_normal(round(5 * RATE)))
    return Signal(level * x / x.std(), RATE, "m/s^2")


surfaces = {
    "ribbed (simulated)": recorded(np.array([0.97 * np.exp(0.25j), 0.8 * np.exp(1.4j)]), 0.5),
    "rough (simulated)": recorded(np.array([0.9 * np.exp(1.2j), 0.5 * np.exp(2.4j)]), 5.0),
}
ribbed, rough = (fit_autoregressive(signal) for signal in surfaces.values())

# %%
# Spectra of recordings, generated signals and their mix
# ------------------------------------------------------

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
for (name, signal), model in zip(surfaces.items(), (ribbed, rough), strict=True):
    made = synthesise(model, signal.seconds, seed=1)
    for kind, x, style in (("recorded", signal, "-"), ("generated", made, "--")):
        frequencies, density = welch(x.samples[0], RATE, nperseg=512)
        axes.semilogy(frequencies, density, style, lw=1, label=f"{name}, {kind}")
grid = np.linspace(1, RATE / 2 - 1, 400)
between = mix([ribbed, rough], [0.5, 0.5])
axes.semilogy(
    grid, between.power_spectrum(grid)[0], "k", lw=2, label="half of each, mixed by line spectral frequencies"
)
axes.set(xlabel="frequency (Hz)", ylabel="power spectral density ((m/s²)²/Hz)")
axes.legend(fontsize=7)
plt.show()

# %%
# A stream that changes from one surface to the other in 1.2 s
# ------------------------------------------------------------

synthesizer = Synthesizer(ribbed, seed=2, glide_s=0.1)
blocks = [synthesizer.next(400) for _ in range(4)]
blocks += [
    synthesizer.next(200, mix([ribbed, rough], [1 - share, share])) for share in np.linspace(0.1, 1, 12)
]
blocks += [synthesizer.next(400) for _ in range(4)]
stream = Signal(np.hstack([block.samples[0] for block in blocks]), RATE, "m/s^2")
steps = np.abs(np.diff(stream.samples[0]))
seams = np.cumsum([len(block) for block in blocks])[:-1] - 1
print(f"largest step at a seam {steps[seams].max():.2f} m/s², anywhere {steps.max():.2f} m/s²")
stream
