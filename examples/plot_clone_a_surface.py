"""
Clone a surface from one stroke
===============================

One recorded stroke, at one speed, becomes a texture at any speed and force. The model comes trained with the package, on
*simulated* surfaces; the stroke is simulated, too.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import tactogram

folder = Path(mkdtemp())

# %%
# The stroke: corduroy at 120 mm/s. Yours would be ``tactogram.read_signal("stroke.csv")``.
model = tactogram.load_run("texture_flow")
(stroke,) = tactogram.generate(model, {"material": "corduroy", "speed_mm_s": 120.0}, seconds=3.0, seed=1)
stroke.plot()

# %%
# The same surface under a faster finger: the ribs follow.
given = {"vibration": stroke, "vibration_speed_mm_s": 120.0, "speed_mm_s": 240.0}
(faster,) = tactogram.generate(model, given, seconds=3.0, seed=2)
faster.plot()

# %%
# Files for an engine and for a spreadsheet.
tactogram.write_signal(folder / "faster.csv", faster)
tactogram.write_signal(folder / "faster.wav", faster)
print(*sorted(file.name for file in folder.iterdir()))
plt.show()
