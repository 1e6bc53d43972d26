"""
Electrovibration: from friction to voltage, under a finger
==========================================================

Turn a friction coefficient over displacement into the amplitude of a carrier. Three things matter: the square root in
the envelope, a constant calibrated for the person, and a voltage that follows the finger and stops when tracking is
lost. Everything here is simulated.
"""

import matplotlib.pyplot as plt
import numpy as np

from tactogram.rendering.drive.electrovibration import Settings, friction
from tactogram.rendering.families.electrovibration import ElectrovibrationStream
from tactogram.rendering.level import Level
from tactogram.signal import Signal
from tactogram_playback import FrictionMeasurements, calibrated

# %%
# Calibration: a simulated person, friction measured six times at each of five voltages.
random = np.random.default_rng(0)
volts = np.repeat([0, 40, 60, 80, 100.0], 6)
measured = 0.3 * (1 + 2e-5 * volts**2 / 0.5) + 0.006 * random.standard_normal(len(volts))
law = calibrated(FrictionMeasurements("simulated person", volts, measured, np.full(len(volts), 0.5)))
settings = Settings(v_max=141, output="envelope", **law.settings())
low, high = law.newton_per_v2_interval
print(
    f"k_e {law.newton_per_v2:.2e} N/V² (95 %: {low:.2e} to {high:.2e}), exponent {law.exponent:.2f} (simulated)"
)
grid = np.linspace(0, 100, 200)
figure, left = plt.subplots(figsize=(7, 4), layout="constrained")
left.plot(volts, measured, ".", color="#1b1f24", label="measured (simulated)")
left.plot(
    grid,
    friction(grid, settings),
    color="#2166ac",
    label=f"μ0 (1 + k V² / F), exponent fitted freely: {law.exponent:.2f}",
)
left.set(xlabel="V rms", ylabel="friction coefficient", title="Calibration of one person")
left.legend(frameon=False, fontsize=8)
plt.show()

# %%
# The square root: a 120 Hz ripple through the square law of the voltage.
time = np.arange(48_000) / 48_000
ripple = 0.5 * (1 + np.sin(2 * np.pi * 120 * time))
figure, middle = plt.subplots(figsize=(6, 4), layout="constrained")
for name, envelope, colour, shift in (
    ("linear envelope", ripple, "#d6604d", -6),
    ("root envelope", np.sqrt(ripple), "#2166ac", 6),
):
    force = np.abs(np.fft.rfft(envelope**2)) / len(time) * 2
    lines = np.array([120, 240])
    middle.bar(lines + shift, force[lines], width=11, color=colour, label=name)
    print(f"{name}: second harmonic {100 * force[240] / force[120]:.1f} % of the first")
middle.set(
    xlabel="Hz", ylabel="modulation of the friction (largest = 1)", title="A 120 Hz ripple in the friction"
)
middle.set_xticks([120, 240])
middle.legend(frameon=False, fontsize=8)
plt.show()

# %%
# A finger that speeds up, stops, lifts, lands elsewhere, and is lost.
place = np.arange(2000) / 20
texture = Signal(0.33 + 0.03 * np.sin(2 * np.pi * place / 2), 20, "1", domain="displacement")
stream = ElectrovibrationStream(texture, settings, rate=8000, level=Level("physical"))
sent, at, x = [], [], 10.0
for block in range(200):  # of 5 ms
    seconds = block * 0.005
    x += 0.005 * (20 + 200 * seconds if seconds < 0.4 else 0)
    lifted = 0.5 <= seconds < 0.6
    news = None if seconds >= 0.8 else [x if seconds < 0.6 else x + 30 + 60 * (seconds - 0.6)]
    sent.append(stream.process(None if lifted else news, 40, contact=not lifted))
    at.append(seconds)
amplitude = np.concatenate(sent)
figure, right = plt.subplots(figsize=(8, 4), layout="constrained")
right.plot(np.arange(len(amplitude)) / 8000, amplitude, color="#2166ac", lw=0.9)
for start, end, name in (
    (0, 0.4, "speeds\nup"),
    (0.4, 0.5, "still"),
    (0.5, 0.6, "lifted"),
    (0.6, 0.8, "elsewhere"),
    (0.8, 1, "lost"),
):
    right.axvspan(start, end, color="#9aa0a6", alpha=0.22 if name in ("still", "elsewhere") else 0.08, lw=0)
    right.text((start + end) / 2, 146, name, ha="center", va="bottom", fontsize=8)
right.axhline(141, color="#d6604d", ls="--", lw=0.8)
right.set(xlabel="s", ylabel="amplitude of the carrier / V", title="Under a simulated finger", ylim=(-4, 168))
plt.show()

# %%
# The amplitude as a signal, to be heard.
Signal(amplitude, 8000, "V")
