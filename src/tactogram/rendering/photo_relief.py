"""A photograph drawn as touch: its brightness taken for height, and felt by its slopes along a stroke.

Slopes push a finger sideways, which is how shapes are felt (Robles-De-La-Torre & Hayward 2001, Nature 412:445), and how
pictures have been drawn for touch since Minsky et al. 1990 (Proc. Symp. Interactive 3D Graphics 24:235). This is a
design, as good as the picture is a relief: brightness tells neither how rough a material is nor how strongly it
vibrates.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import READ_RATE
from tactogram.signal import Image, Signal
from tactogram.signal.displacement import played

WIDTH_MM, SPEED_MM_S = 100.0, 100.0
"""Of a photograph, unless stated: the width that it shows, and the speed of the stroke across it."""
TIP_MM = 0.2
"""Standard deviation of the area that is felt at once: about that of a pen's tip."""
WIDE_MM = 5.0
"""Standard deviation beyond which slopes are taken for the light of the scene."""
LEAST_CONTRAST = 0.02
"""Of the full range of brightness; less is noise of the camera."""
LUMA = np.array([0.2126, 0.7152, 0.0722], np.float32)
"""Weights of red, green and blue (ITU-R BT.709)."""


def photo_to_touch(photograph: Image, *, speed_mm_s: float = SPEED_MM_S, rate: float = READ_RATE) -> Signal:
    """Return what a stroke along the middle row, from left to right, meets over time: one axis of unit 1.

    As `slopes_of`, at a speed in mm/s and a rate in Hz.
    """
    signal = played(slopes_of(photograph), speed_mm_s, rate)
    return signal.with_samples(signal.samples / np.abs(signal.samples).max())


def slopes_of(photograph: Image) -> Signal:
    """Return the slopes along the middle row, from left to right, over displacement: one axis of unit 1.

    The steepest is 1 or -1: uphill is positive. The photograph's ``mm_per_pixel`` must be known. Raises
    `ParameterError` if it is not, or the row shows no contrast.
    """
    scale = photograph.mm_per_pixel
    if scale is None:
        raise ParameterError("the photograph's scale is unknown; give the width that it shows")
    rows, columns = photograph.size
    tip = TIP_MM / scale
    reach = int(np.ceil(4 * tip))
    band = photograph.pixels[max(0, rows // 2 - reach) : rows // 2 + reach + 1]
    heights = gaussian_filter(band.astype(np.float32) @ LUMA / 255, tip)[min(reach, rows // 2)]
    if columns < 2 or np.ptp(heights) < LEAST_CONTRAST:
        raise ParameterError(
            "the middle of the photograph has no contrast to draw; crop it to the part to be felt"
        )
    slopes = np.gradient(heights.astype(np.float64))
    slopes -= gaussian_filter1d(slopes, WIDE_MM / scale)
    return Signal(slopes[None] / np.abs(slopes).max(), 1 / scale, "1", ("slope",), domain="displacement")
