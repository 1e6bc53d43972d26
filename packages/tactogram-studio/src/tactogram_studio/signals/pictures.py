"""Signal pictures: waveform, spectrogram, and spectrum with the detection threshold, as chart options and pixels.

All are pure functions of `SignalTraits`; signals shown together share `SharedScales`.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from tactogram.signal import FELT_HZ, detection_threshold
from tactogram_studio.signals.traits import WITH_THRESHOLD, SharedScales, SignalTraits, scales_of, unit_text

COLOURS = ("#2166ac", "#c0452f", "#3f7d1d", "#6d5fa8", "#9a4a04", "#555555")
"""For axes, in order; contrast at least 4.5:1 on white."""
THRESHOLD_COLOUR = "#8a5a00"
TICKS = {"fontSize": 11, "color": "#51606e"}
GRID_LINES = {"lineStyle": {"color": "#e6ebef"}}
RANGE_DB = 70.0
"""Range of a spectrogram's colours."""


def waveform_options(traits: SignalTraits, *, scales: SharedScales | None = None) -> dict[str, Any]:
    """Return the options of an ECharts line chart with a row for each axis, mean removed, on one scale."""
    scales = scales or scales_of([traits])
    rows = len(traits.axes)
    top, unit = _nice(scales.peak), unit_text(traits.unit)
    grids, x_axes, y_axes, series, data = [], [], [], [], []
    for row, (name, (indices, value)) in enumerate(zip(traits.axes, traits.curves, strict=True)):
        grids.append({"left": 64, "right": 12, "top": 8 + 84 * row, "height": 66})
        x_axes.append(
            {
                "type": "value",
                "gridIndex": row,
                "min": 0,
                "max": _digits(scales.extent),
                "axisLabel": {**TICKS, "show": row == rows - 1, "hideOverlap": True},
                "name": ("s" if traits.domain == "time" else "mm") if row == rows - 1 else "",
                "nameLocation": "end",
                "nameGap": -8,
                "nameTextStyle": {**TICKS, "verticalAlign": "top", "padding": [22, 0, 0, 0]},
                "axisLine": {"onZero": False},
                "splitLine": {"show": False},
            }
        )
        y_axes.append(
            {
                "type": "value",
                "gridIndex": row,
                "min": -top,
                "max": top,
                "interval": top,
                "splitLine": GRID_LINES,
                **_titled(f"{name}, {unit}" if rows > 1 else unit, 44),
            }
        )
        # Two lists, not one per point: the server watches every list for changes.
        columns = {"t": [_digits(p / traits.rate) for p in indices], "v": [_digits(v) for v in value]}
        data.append({"source": columns})
        series.append(
            {
                "type": "line",
                "name": name,
                "datasetIndex": row,
                "encode": {"x": "t", "y": "v"},
                "xAxisIndex": row,
                "yAxisIndex": row,
                "showSymbol": False,
                "silent": True,
                "lineStyle": {"width": 1, "color": COLOURS[row % len(COLOURS)]},
                "animation": False,
            }
        )
    return {
        "animation": False,
        "grid": grids,
        "xAxis": x_axes,
        "yAxis": y_axes,
        "dataset": data,
        "series": series,
    }


def waveform_height(traits: SignalTraits) -> int:
    """Return the height of its waveform chart, pixels."""
    return 84 * len(traits.axes) + 22


def card_height(axes: int, *, small: bool) -> int:
    """Return the height of a card's pictures and texts, pixels, to reserve their space; ``small`` has no spectrum."""
    return 84 * axes + 290 + (0 if small else 206)


def spectrogram_png(
    traits: SignalTraits, *, width: int = 640, height: int = 160, scales: SharedScales | None = None
) -> bytes:
    """Return the spectrogram as PNG without axes: time to the right, frequency upwards, transparent after its end."""
    from matplotlib import colormaps

    scales = scales or scales_of([traits])
    frequency, level = traits.frequency, traits.level
    rows = max(1, round(height * min(1.0, float(frequency[-1]) / scales.top_hz))) if frequency[-1] else height
    columns = max(1, round(width * min(1.0, traits.extent / scales.extent)))
    share = np.clip((level - scales.top_db) / RANGE_DB + 1, 0, 1)
    pixels = (colormaps["magma"](share[::-1])[..., :3] * 255).round().astype(np.uint8)
    shown = Pillow.fromarray(pixels, "RGB").resize((columns, rows), Pillow.Resampling.BILINEAR)
    picture = Pillow.new("RGBA", (width, height), (0, 0, 0, 0))
    picture.paste(shown, (0, height - rows))
    out = io.BytesIO()
    picture.save(out, "PNG")
    return out.getvalue()


def spectrum_options(traits: SignalTraits, *, others: Sequence[SignalTraits] = ()) -> dict[str, Any]:
    """Return the options of an ECharts chart: third-octave levels, and the detection threshold if the unit has one.

    The vertical axis also covers the ``others``.
    """
    frequency, amplitude = traits.bands
    over_time = traits.domain == "time"
    series = [_line("level", frequency, amplitude, COLOURS[0], symbol=True)]
    values = np.concatenate([amplitude, *(other.bands[1] for other in others if other.unit == traits.unit)])
    values = values[values > 0]
    top = float(values.max()) if len(values) else 0.0
    if over_time and traits.unit in WITH_THRESHOLD:
        f = np.geomspace(*FELT_HZ, 60)
        threshold = detection_threshold(f, traits.unit)
        series.append(_line("detection threshold", f, threshold, THRESHOLD_COLOUR, dashed=True))
        top = max(top, 5 * float(threshold.min()))
    top = top or 1.0
    bottom = max(float(values.min()), top * 1e-4) if len(values) else top * 1e-3
    low, high = FELT_HZ if over_time else (_bound(frequency, 0, 0.01), _bound(frequency, -1, 1.0))
    return {
        "animation": False,
        "legend": {"top": 0, "right": 8, "itemHeight": 8, "textStyle": TICKS, "selectedMode": False},
        "grid": {"left": 64, "right": 16, "top": 26, "bottom": 36},
        "xAxis": {
            "type": "log",
            "min": _digits(low),
            "max": _digits(high),
            "minorSplitLine": {"show": False},
            **_titled("Hz" if over_time else "cycles per mm", 22),
        },
        "yAxis": {
            "type": "log",
            "min": 10.0 ** math.floor(math.log10(bottom)),
            "max": 10.0 ** math.ceil(math.log10(top)),
            "splitLine": GRID_LINES,
            **_titled(unit_text(traits.unit), 46),
        },
        "series": series,
    }


def _line(
    name: str,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    colour: str,
    *,
    symbol: bool = False,
    dashed: bool = False,
) -> dict[str, Any]:
    return {
        "type": "line",
        "name": name,
        "data": [[_digits(a), _digits(b)] for a, b in zip(x, y, strict=True) if b > 0],
        "showSymbol": symbol,
        "symbolSize": 5,
        "silent": True,
        "clip": True,
        "animation": False,
        "itemStyle": {"color": colour},
        "lineStyle": {"width": 1.5, "color": colour, "type": "dashed" if dashed else "solid"},
    }


def _titled(name: str, gap: int) -> dict[str, Any]:
    return {
        "name": name,
        "nameLocation": "middle",
        "nameGap": gap,
        "nameTextStyle": TICKS,
        "axisLabel": TICKS,
    }


def _bound(values: NDArray[np.float64], index: int, otherwise: float) -> float:
    return float(values[index]) if len(values) else otherwise


def _digits(value: float) -> float:
    """Return a number with four significant digits, enough for a picture and short to send."""
    return float(f"{value:.4g}")


def _nice(value: float) -> float:
    """Return the least of 1, 2, 5 times a power of ten that is at least ``value``."""
    power = 10.0 ** math.floor(math.log10(value))
    return _digits(next(power * step for step in (1, 2, 5, 10) if power * step >= value * (1 - 1e-9)))
