"""
Under a moving finger
=====================

A finger is never as steady as a test bench: it starts, turns, rests and lifts. Give a model the motion of a finger over
time, and the vibration follows it.
"""

# sphinx_gallery_thumbnail_number = -1

import matplotlib.pyplot as plt
import numpy as np

import tactogram

# %%
# A `Motion` is speed over time, with force and contact where they are known. This finger strokes three times, faster
# each time, and rests in between. ``tactogram generate --motion hand.csv`` reads a recorded one.

seconds = np.linspace(0, 4.5, 451)
stroke = np.sin(np.pi * (seconds % 1.5) / 1.2)
speed = (
    np.where(seconds % 1.5 < 1.2, stroke, 0)
    * np.array([80, 160, 320])[np.minimum(seconds // 1.5, 2).astype(int)]
)
motion = tactogram.Motion(seconds, speed, gain=np.clip(speed / 10, 0, 1))

# %%
# One material, one motion, one signal.

textures = tactogram.load_run("texture_flow")
(felt,) = tactogram.generate(textures, {"material": "bamboo-mat", "motion": motion}, seconds=4.5, seed=3)
felt

# %%
# The vibration is silent where the finger rests, and stronger and higher where it is fast.

figure, (top, bottom) = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
top.plot(motion.time_s, motion.speed_mm_s)
top.set(ylabel="speed (mm/s)", title="bamboo mat (simulated) under a moving finger")
bottom.plot(np.arange(len(felt)) / felt.rate, felt.samples[0], lw=0.4)
bottom.set(xlabel="time (s)", ylabel=f"acceleration ({felt.unit})")
for number in range(3):
    part = felt.cut(round(1.5 * number * felt.rate), round(1.5 * (number + 1) * felt.rate))
    print(f"stroke {number + 1}: {np.sqrt((part.samples**2).mean()):.2f} m/s² rms (generated)")
plt.show()
