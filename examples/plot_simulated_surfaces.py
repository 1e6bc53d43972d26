"""
Simulated surfaces: photograph and acceleration
===============================================

Simulate a photograph of four of the paper's surfaces, and the acceleration of a finger that strokes each back and
forth at 200 mm/s, both from the same height field. Everything here is simulated.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import spectrogram

from tactogram.signal.filters import bandpass
from tactogram_simulate import make, tasks

# %%
# A recording is described before it is made, so that it can be made anywhere; here the sensor is a faster one.
wanted = ["carpet2", "sponge-b", "whitetile3", "woodtile2"]
todo = [
    replace(task, rate=1000.0)
    for task in tasks("stroking30", seed=1, per_class=1, seconds=4)
    if task.contactor == "finger" and task.speed_mm_s == 200
]
recordings = {recording.material: recording for recording in map(make, (todo[i] for i in (1, 5, 11, 13)))}

# %%
# Turns are seen as pauses, ridges as lines: a period of 3.4 mm at 200 mm/s is 59 Hz.
figure, axes = plt.subplots(
    3, len(wanted), figsize=(13, 7.5), layout="constrained", height_ratios=(2, 1, 1.5)
)
for (photo, wave, power), name in zip(axes.T, wanted, strict=True):
    recording = recordings[name]
    pixels = recording.image.pixels
    width = pixels.shape[1] * recording.image.mm_per_pixel
    photo.imshow(pixels, extent=(0, width, width, 0))
    photo.set(title=f"{name} (simulated)", xlabel="mm")
    acceleration = recording.stream("acceleration")
    z = bandpass(acceleration.select("z"), 20, 400).samples[0]
    wave.plot(np.arange(z.size) / acceleration.rate, z, lw=0.4)
    wave.set(ylabel="z, 20–400 Hz / m/s²", xlabel="s", ylim=(-25, 25))
    f, t, density = spectrogram(z, acceleration.rate, nperseg=128, noverlap=112)
    power.pcolormesh(t, f, 10 * np.log10(density + 1e-9), vmin=-45, vmax=5, cmap="magma")
    power.set(xlabel="s", ylabel="Hz", ylim=(0, 400))
    level = float(np.sqrt((z**2).mean()))
    friction = np.abs(recording.stream("friction").samples).mean()
    print(f"{name}: {level:.2f} m/s² rms on z, mean friction coefficient {friction:.2f} (simulated)")
plt.show()

# %%
# The carpet, as its sensor measured it.
recordings["carpet2"].stream("acceleration")
