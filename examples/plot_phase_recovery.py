"""
Phase recovery: from a spectrogram back to a vibration
======================================================

Generative networks produce magnitudes without phase. Recover the phase of a simulated texture by three methods and
compare their errors.
"""

# sphinx_gallery_thumbnail_number = 2

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from tactogram.features import Spectrogram, spectral_convergence
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass

rate, seconds = 2500, 3.0
random = np.random.default_rng(0)
noise = Signal(random.standard_normal(int(rate * seconds)), rate, "m/s^2")
time = np.arange(len(noise)) / rate
strokes = np.abs(np.sin(np.pi * time))  # the hand slows down at each end
texture = bandpass(noise, 60, 400)
texture = texture.with_samples(texture.samples * strokes + 0.3 * strokes * np.sin(2 * np.pi * 150 * time))

texture

# %%
# A Spectrogram fixes the transform, and the mapping of amplitudes in m/s² to values from -1 to 1.
spectrogram = Spectrogram(rate=rate, unit="m/s^2", n_fft=256, hop=64, floor_db=-80, ceil_db=6)
z = spectrogram.encode_signal(texture)
target = spectrogram.magnitude(z)[0]

# %%
# The picture has no phase. `decode` recovers one: by default from the gradient of the magnitude, then refined.
methods = {
    "Griffin-Lim": replace(spectrogram, start="random", iteration="griffin_lim"),
    "fast Griffin-Lim": replace(spectrogram, start="random", iteration="fast_griffin_lim"),
    "gradient start, ADMM, momentum": spectrogram,
}
counts = [1, 2, 4, 8, 16, 32, 64, 128]
figure, left = plt.subplots(figsize=(8, 4), layout="constrained")
for name, method in methods.items():
    errors = []
    for count in counts:
        x = replace(method, iterations=count).decode(z[0], len(texture))
        errors.append(float(spectral_convergence(x, target, spectrogram.transform)))
    left.semilogx(counts, errors, "o-", base=2, label=name)
    print(f"{name}: {errors[5]:.1f} dB after 32 iterations, {errors[7]:.1f} dB after 128")
left.set(xlabel="iterations", ylabel="spectral convergence / dB", title="Lower is better (simulated texture)")
left.grid(alpha=0.3)
left.legend()
plt.show()

# %%
# The recovered vibration has the level of the first: values are absolute.
again = spectrogram.decode_signal(z, len(texture))
before, after = float(texture.samples.std()), float(again.samples.std())
print(f"{before:.3f} m/s² rms before, {after:.3f} after")
again
