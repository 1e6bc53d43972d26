"""Moving picture of the README: a finger strokes a simulated surface, and the vibration follows.

``python docs/moving_picture.py`` writes docs/stroke.svg, which every browser animates.
"""

import base64
import io
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from tactogram.signal.filters import bandpass
from tactogram_simulate import make, tasks

SECONDS, RATE = 4.0, 1000.0
WIDTH, SURFACE, TRACE = 880, 120, 150
"""Pixels: of the picture, and the heights of the surface and of the trace."""
MARGIN = 40
POINTS = 1760


def main() -> None:
    """Simulate the stroke and write the picture."""
    strokes = [
        replace(task, rate=RATE)
        for task in tasks("stroking30", seed=1, per_class=1, seconds=SECONDS)
        if task.contactor == "finger" and task.speed_mm_s == 200
    ]
    recording = next(one for one in map(make, strokes) if one.material == "carpet2")
    vibration = bandpass(recording.stream("acceleration").select("z"), 20, 400).samples[0]
    position = recording.stream("position").select("x").samples[0] * 1000  # mm
    Path(__file__).with_name("stroke.svg").write_text(
        picture(recording.image.pixels, position, vibration), encoding="utf-8"
    )


def picture(photograph: np.ndarray, position: np.ndarray, vibration: np.ndarray) -> str:
    """Return the animated SVG.

    Parameters
    ----------
    photograph : uint8 array, shape (height, width, 3)
    position : float array, shape (time,)
        Along the surface, any unit.
    vibration : float array, shape (time,)
    """
    low, high = position.min(), position.max()
    across = MARGIN + (WIDTH - 2 * MARGIN) * (position - low) / (high - low)
    finger = ";".join(f"{x:.0f}" for x in across[:: max(1, len(across) // 100)])
    edges = np.linspace(0, len(vibration), POINTS // 2 + 1).astype(int)
    middle, scale = SURFACE + TRACE / 2 + 10, (TRACE / 2 - 6) / np.abs(vibration).max()
    line = []
    for number, (start, end) in enumerate(pairwise(edges)):
        x = WIDTH * number / (POINTS // 2)
        piece = vibration[start:end]
        line += [
            f"{x:.1f},{middle - scale * piece.max():.1f}",
            f"{x + 0.5:.1f},{middle - scale * piece.min():.1f}",
        ]
    seconds = f'dur="{SECONDS:g}s" repeatCount="indefinite"'
    height = SURFACE + TRACE + 20
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">
<title>A finger strokes a simulated carpet, and the vibration follows</title>
<defs>
<pattern id="surface" width="{SURFACE}" height="{SURFACE}" patternUnits="userSpaceOnUse">
<image href="data:image/jpeg;base64,{_jpeg(photograph)}" width="{SURFACE}" height="{SURFACE}"/>
</pattern>
<radialGradient id="skin">
<stop offset="0" stop-color="#f3c9ab"/><stop offset="1" stop-color="#c98b63"/></radialGradient>
<clipPath id="drawn"><rect x="0" y="{SURFACE}" height="{TRACE + 20}" width="{WIDTH}">
<animate attributeName="width" from="0" to="{WIDTH}" {seconds}/></rect></clipPath>
</defs>
<rect width="{WIDTH}" height="{SURFACE}" rx="8" fill="url(#surface)"/>
<g><ellipse cy="{SURFACE / 2:g}" rx="20" ry="27" fill="url(#skin)" stroke="#8a5a3c" stroke-width="1.5" opacity="0.92">
<animate attributeName="cx" values="{finger}" {seconds}/></ellipse></g>
<polyline points="{" ".join(line)}" fill="none" stroke="#7f8fa6" stroke-opacity="0.28" stroke-width="1"/>
<polyline points="{" ".join(line)}" fill="none" stroke="#2f7ed8" stroke-width="1.1" clip-path="url(#drawn)"/>
</svg>
"""


def _jpeg(photograph: np.ndarray) -> str:
    file = io.BytesIO()
    Image.fromarray(photograph).resize((2 * SURFACE, 2 * SURFACE)).save(file, "JPEG", quality=70)
    return base64.b64encode(file.getvalue()).decode()


if __name__ == "__main__":
    main()
