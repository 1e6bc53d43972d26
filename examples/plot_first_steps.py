"""
First steps: from a name to a touch
===================================

Generate the vibration of a finger on corduroy, listen to it, stroke faster, mix it with silk, describe a surface in
words, and write a file that a phone plays. The model comes with the package, trained on *simulated* surfaces: there is
nothing to download and nothing to train.
"""

import tempfile
from pathlib import Path

import numpy as np

import tactogram

# %%
# A run is a trained model. `texture_flow` knows 88 simulated materials by name.

textures = tactogram.load_run("texture_flow")
print(*textures.kind.materials[:12], "…", sep=", ")

# %%
# What to generate is a condition: here a material, and how fast the finger moves. The result is a `Signal`:
# acceleration in m/s², with its rate. A notebook shows it like this, with a player.

corduroy = {"material": "corduroy", "speed_mm_s": 80.0}
(slow,) = tactogram.generate(textures, corduroy, seconds=3.0, seed=1)
slow

# %%
# Three times as fast: the ribs pass three times as often, and the vibration is stronger.

(fast,) = tactogram.generate(textures, corduroy | {"speed_mm_s": 240.0}, seconds=3.0, seed=1)
for name, signal in {"80 mm/s": slow, "240 mm/s": fast}.items():
    print(f"{name}: {np.sqrt((signal.samples**2).mean()):.2f} m/s² rms (generated, simulated surface)")
fast

# %%
# Materials can be mixed. The players above and below are scaled to be heard; `Signal` keeps the level.

(mixed,) = tactogram.generate(
    textures, {"material": {"corduroy": 0.4, "silk": 0.6}, "speed_mm_s": 240.0}, seconds=3.0, seed=1
)
mixed

# %%
# Words do as well: scores from 1 to 7 for any of the words that the run knows.

print(*textures.kind.words, sep=", ")
(rough,) = tactogram.generate(
    textures, {"words": {"rough": 6.0, "sticky": 2.0}, "speed_mm_s": 150.0}, seconds=3.0, seed=1
)
rough

# %%
# A file for a phone holds the envelope of the vibration, not its samples. `convert` writes it and says what it
# keeps.

folder = Path(tempfile.mkdtemp())
tactogram.write_signal(folder / "corduroy.wav", fast)
loss = tactogram.convert(folder / "corduroy.wav", folder / "corduroy.ahap")["written"]["loss"]
print(f"correlation of the envelope {loss['envelope_correlation']:.3f}, level {loss['level_db']:+.2f} dB")
