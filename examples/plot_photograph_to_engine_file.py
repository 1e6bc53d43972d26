"""
From a photograph to a file for an engine
=========================================

A photograph of a surface becomes a vibration, and that a haptic file for a phone. ``nearest_photo`` plays the recording
whose photograph is most alike: on the benchmark no network comes closer. Without recordings, a photograph can be drawn
as a relief, which is a design and no prediction. Photographs and recordings are *simulated*.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import tactogram
from tactogram.signal.io import write_image
from tactogram_simulate import simulate_to_store

folder = Path(mkdtemp())

# %%
# A store of recordings with two photographs of each surface.
simulate_to_store("stroking9", folder / "store", per_class=3, photographs=2, seconds=2, seed=1, workers=1)
store = tactogram.open_store(folder / "store")
photograph = store.photograph(store.photographs_of("carpet")[0])
plt.imshow(photograph.pixels)
plt.axis("off")

# %%
# Training takes a second; the photograph is then given as one of a phone's camera would be.
run = tactogram.train("nearest_photo", folder / "store", out=folder / "run")
(signal,) = tactogram.generate(tactogram.load_run(run.folder), {"image": photograph}, seconds=2.0, seed=1)
signal.plot()

# %%
# The file, and what is lost in it.
tactogram.write_signal(folder / "carpet.wav", signal)
for suffix in ("ahap", "haptic"):
    written = tactogram.convert(folder / "carpet.wav", folder / f"carpet.{suffix}")["written"]
    kept = written["loss"]["envelope_correlation"]
    print(f"carpet.{suffix}: {written['bytes']} bytes, the envelope kept at a correlation of {kept:.2f}")

# %%
# Without any recording: the brightness of tiles as heights, and what the tip of a pen meets at 100 mm/s.
tiles = store.photograph(store.photographs_of("tile")[0])
write_image(folder / "tiles.png", tiles)
tactogram.convert(folder / "tiles.png", folder / "tiles.wav", width_mm=tiles.size[1] * tiles.mm_per_pixel)
drawn = tactogram.read_signal(folder / "tiles.wav")
figure, (above, below) = plt.subplots(2, figsize=(6, 4), layout="constrained")
above.imshow(tiles.pixels[tiles.size[0] // 2 - 30 :][:60], aspect="auto")
above.axis("off")
below.plot(np.arange(len(drawn)) / drawn.rate, drawn.samples[0])
below.set(xlabel="time, s", ylabel="slope", xlim=(0, drawn.seconds))
plt.show()
