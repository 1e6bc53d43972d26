"""What of a signal is drawn: waveform, spectrogram and spectrum beside the detection threshold, as values and pixels.

Everything here is a pure function of signals. Signals that stand side by side are drawn on the same `Scales`.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from scipy import signal as dsp

from tactogram.signal import Signal
from tactogram.signal.perception import FELT_HZ, detection_threshold, sensation_level_db

COLOURS = ("#2166ac", "#c0452f", "#3f7d1d", "#6d5fa8", "#9a4a04", "#555555")
"""Of axes, in order; each at least 4.5:1 on white."""
THRESHOLD_COLOUR = "#8a5a00"
RANGE_DB = 70.0
"""From black to white of a spectrogram."""
WITH_THRESHOLD = ("m", "m/s", "m/s^2")
BANDS_PER_DECADE = 10
"""Third octaves, base ten (IEC 61260-1)."""
UNITS = {"m/s^2": "m/s²", "1": "(ratio)"}


@dataclass(frozen=True)
class Scales:
    """What the pictures of signals that stand side by side have in common.

    Parameters
    ----------
    peak : float
        Largest deviation from an axis' mean, in the unit.
    extent : float
        Of the longest, s or mm.
    top_db : float
        Brightest level of the spectrograms, dB re 1 unit.
    top_hz : float
        Where the spectrograms end: Hz, or cycles per mm.
    """

    peak: float
    extent: float
    top_db: float
    top_hz: float


def scales_of(signals: Sequence[Signal]) -> Scales:
    """Return the scales on which all of ``signals`` fit, at least one."""
    return Scales(
        peak=max(peak_of(signal) for signal in signals) or 1.0,
        extent=max(signal.extent for signal in signals),
        top_db=max(float(spectrogram_db(signal)[2].max()) for signal in signals),
        top_hz=max(_top_hz(signal) for signal in signals),
    )


def rms_of(signal: Signal) -> float:
    """Return the root of the mean square about the mean, all axes together: that of the DFT321 of them."""
    return float(np.sqrt(_centred(signal).var(axis=1).sum()))


def peak_of(signal: Signal) -> float:
    """Return the largest deviation from its mean of any axis."""
    return float(np.abs(_centred(signal)).max())


def unit_of(signal: Signal) -> str:
    """Return the unit as people write it."""
    return UNITS.get(signal.unit, signal.unit)


def threshold_note(signal: Signal) -> str:
    """Return in a sentence how far above the detection threshold the signal is, or why that cannot be said."""
    if signal.domain != "time":
        return "Over displacement it is felt only at a speed: no threshold is drawn."
    if signal.unit not in WITH_THRESHOLD:
        return f"No detection threshold is known in {unit_of(signal)}: none is drawn."
    level = sensation_level_db(signal)
    if not math.isfinite(level):
        return f"Nothing in {FELT_HZ[0]:g} to {FELT_HZ[1]:g} Hz: it cannot be felt."
    return f"{abs(level):.0f} dB {'above' if level >= 0 else 'below'} the detection threshold (good to some 10 dB)."


def envelope(samples: NDArray[np.float32], width: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return where in ``samples`` the least and the greatest of each of ``width`` pixels stand, and these values.

    Parameters
    ----------
    samples : float32 array, shape (time,)
    width : int
        Pixels.

    Returns
    -------
    place : int64 array, shape (point,)
        Rising.
    value : float32 array, shape (point,)
        Every sample where there are no more than two for a pixel.
    """
    n = len(samples)
    if n <= 2 * width:
        return np.arange(n), samples
    edges = (np.arange(width) * n) // width
    spans = [slice(a, b) for a, b in zip(edges, [*edges[1:], n], strict=True)]
    places = np.array(
        sorted({s.start + int(f(samples[s])) for s in spans for f in (np.argmin, np.argmax)}), np.int64
    )
    return places, samples[places]


def waveform_options(signal: Signal, *, width: int = 600, scales: Scales | None = None) -> dict[str, Any]:
    """Return the options of an ECharts line chart: a row for each axis, on one scale, about its mean.

    Parameters
    ----------
    signal : Signal
    width : int
        Pixels; the least and the greatest of each stay.
    scales : Scales, optional
        By default the signal's own.
    """
    scales = scales or scales_of([signal])
    rows = len(signal.axes)
    top = _nice(scales.peak)
    ticks = {"fontSize": 11, "color": "#51606e"}
    grids, x_axes, y_axes, series = [], [], [], []
    for row, (name, x) in enumerate(zip(signal.axes, _centred(signal), strict=True)):
        place, value = envelope(x.astype(np.float32), width)
        grids.append({"left": 64, "right": 12, "top": 8 + 84 * row, "height": 66})
        x_axes.append(
            {
                "type": "value",
                "gridIndex": row,
                "min": 0,
                "max": _digits(scales.extent),
                "axisLabel": {**ticks, "show": row == rows - 1, "hideOverlap": True},
                "name": ("s" if signal.domain == "time" else "mm") if row == rows - 1 else "",
                "nameLocation": "end",
                "nameGap": -8,
                "nameTextStyle": {**ticks, "verticalAlign": "top", "padding": [22, 0, 0, 0]},
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
                "axisLabel": ticks,
                "name": f"{name} {unit_of(signal)}",
                "nameLocation": "middle",
                "nameGap": 44,
                "nameTextStyle": ticks,
                "splitLine": {"lineStyle": {"color": "#e6ebef"}},
            }
        )
        points = [[_digits(p / signal.rate), _digits(v)] for p, v in zip(place, value, strict=True)]
        series.append(
            {
                "type": "line",
                "name": name,
                "data": points,
                "xAxisIndex": row,
                "yAxisIndex": row,
                "showSymbol": False,
                "silent": True,
                "lineStyle": {"width": 1, "color": COLOURS[row % len(COLOURS)]},
                "animation": False,
            }
        )
    return {"animation": False, "grid": grids, "xAxis": x_axes, "yAxis": y_axes, "series": series}


def waveform_height(signal: Signal) -> int:
    """Return the height of its waveform chart, pixels."""
    return 84 * len(signal.axes) + 22


def spectrogram_db(
    signal: Signal, *, top_hz: float | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the level over time and frequency, power of all axes added up.

    A sine of amplitude a on a bin stands as 20 log10(a) dB in its middle; Hann, about 32 ms (or mm), three quarters
    overlap, about the mean of each axis.

    Parameters
    ----------
    signal : Signal
    top_hz : float, optional
        Where it ends; by default 1 kHz or half the rate.

    Returns
    -------
    frequency : float64 array, shape (frequency,), Hz or cycles per mm
    time : float64 array, shape (time,), s or mm
        Middle of each column.
    level : float64 array, shape (frequency, time), dB re 1 unit
        At least -200.
    """
    x = _centred(signal)
    width = min(len(signal), max(64, 2 ** round(math.log2(max(2.0, signal.rate * _window_of(signal))))))
    if width < 2:
        x, width = np.pad(x, ((0, 0), (0, 1))), 2
    hop = max(1, width // 4)
    window = dsp.get_window("hann", width) if width > 3 else np.ones(width)
    pad = width // 2
    x = np.pad(x, ((0, 0), (pad, pad + hop)), mode="symmetric")  # a cut to silence would be a click
    starts = np.arange(0, x.shape[1] - width + 1, hop)
    starts = starts[starts <= len(signal)]
    frames = np.lib.stride_tricks.sliding_window_view(x, width, axis=1)[:, starts]
    spectra = np.fft.rfft(frames * window, axis=2)  # axis, time, frequency
    power = (np.abs(spectra) ** 2).sum(0).T * (2 / window.sum()) ** 2
    power[0] /= 4  # what does not swing has no second half
    frequency = np.asarray(np.fft.rfftfreq(width, 1 / signal.rate), np.float64)
    kept = frequency <= (top_hz or _top_hz(signal)) * (1 + 1e-9)
    return frequency[kept], starts / signal.rate, 10 * np.log10(np.maximum(power[kept], 1e-20))


def spectrogram_png(
    signal: Signal, *, width: int = 640, height: int = 160, scales: Scales | None = None
) -> bytes:
    """Return the spectrogram as PNG without axes: time to the right, frequency upwards; transparent after its end.

    Parameters
    ----------
    signal : Signal
    width, height : int
        Pixels.
    scales : Scales, optional
        By default the signal's own.
    """
    from matplotlib import colormaps

    scales = scales or scales_of([signal])
    frequency, _, level = spectrogram_db(signal, top_hz=scales.top_hz)
    rows = max(1, round(height * min(1.0, float(frequency[-1]) / scales.top_hz))) if frequency[-1] else height
    columns = max(1, round(width * min(1.0, signal.extent / scales.extent)))
    share = np.clip((level - scales.top_db) / RANGE_DB + 1, 0, 1)
    pixels = (colormaps["magma"](share[::-1])[..., :3] * 255).round().astype(np.uint8)
    shown = Pillow.fromarray(pixels, "RGB").resize((columns, rows), Pillow.Resampling.BILINEAR)
    picture = Pillow.new("RGBA", (width, height), (0, 0, 0, 0))
    picture.paste(shown, (0, height - rows))
    out = io.BytesIO()
    picture.save(out, "PNG")
    return out.getvalue()


def band_levels(signal: Signal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return in third octaves the peak amplitude of the sine that has a band's power, all axes added up.

    A noise is felt by its power in a band, and a threshold is that of a sine: so both are on one scale.

    Returns
    -------
    frequency : float64 array, shape (band,)
        Middles within `FELT_HZ`, below half the rate, each band at least one bin wide; in cycles per mm over
        displacement, from one in the whole length.
    amplitude : float64 array, shape (band,), in the signal's unit
    """
    x = _centred(signal)
    n = len(signal)
    power = (np.abs(np.fft.rfft(x, axis=1)) ** 2).sum(0) / n**2
    power[1 : (n + 1) // 2] *= 2
    step = signal.rate / n
    edges = (np.arange(len(power) + 1) - 0.5) * step
    total = np.concatenate([[0.0], np.cumsum(power)])
    ratio = 10 ** (0.5 / BANDS_PER_DECADE)
    narrowest = step / (ratio - 1 / ratio)
    low, high = FELT_HZ if signal.domain == "time" else (narrowest, signal.rate / 2)
    first = math.ceil(BANDS_PER_DECADE * math.log10(max(low * 0.99, narrowest)) - 1e-9)
    last = math.floor(BANDS_PER_DECADE * math.log10(min(high * 1.01, signal.rate / 2 / ratio)) + 1e-9)
    middle = 10 ** (np.arange(first, last + 1) / BANDS_PER_DECADE)
    held = np.interp(middle * ratio, edges, total) - np.interp(middle / ratio, edges, total)
    return middle, np.sqrt(2 * np.maximum(held, 0))


def spectrum_options(signal: Signal, *, others: Sequence[Signal] = ()) -> dict[str, Any]:
    """Return the options of an ECharts chart: levels in third octaves, with the threshold where there is one.

    Parameters
    ----------
    signal : Signal
    others : sequence of Signal
        That the vertical axis is to hold, too.
    """
    frequency, amplitude = band_levels(signal)
    over_time = signal.domain == "time"
    series = [_line("level", frequency, amplitude, COLOURS[0], symbol=True)]
    values = np.concatenate(
        [amplitude, *(band_levels(other)[1] for other in others if other.unit == signal.unit)]
    )
    values = values[values > 0]
    top = float(values.max()) if len(values) else 0.0
    if over_time and signal.unit in WITH_THRESHOLD:
        f = np.geomspace(*FELT_HZ, 60)
        threshold = detection_threshold(f, signal.unit)
        series.append(_line("detection threshold", f, threshold, THRESHOLD_COLOUR, dashed=True))
        top = max(top, 5 * float(threshold.min()))
    top = top or 1.0
    bottom = max(float(values.min()), top * 1e-4) if len(values) else top * 1e-3
    ticks = {"fontSize": 11, "color": "#51606e"}
    low, high = FELT_HZ if over_time else (_bound(frequency, 0, 0.01), _bound(frequency, -1, 1.0))
    return {
        "animation": False,
        "legend": {"top": 0, "right": 8, "itemHeight": 8, "textStyle": ticks, "selectedMode": False},
        "grid": {"left": 64, "right": 16, "top": 26, "bottom": 36},
        "xAxis": {
            "type": "log",
            "min": _digits(low),
            "max": _digits(high),
            "name": "Hz" if over_time else "cycles per mm",
            "nameLocation": "middle",
            "nameGap": 22,
            "nameTextStyle": ticks,
            "axisLabel": ticks,
            "minorSplitLine": {"show": False},
        },
        "yAxis": {
            "type": "log",
            "min": 10.0 ** math.floor(math.log10(bottom)),
            "max": 10.0 ** math.ceil(math.log10(top)),
            "name": unit_of(signal),
            "nameLocation": "middle",
            "nameGap": 46,
            "nameTextStyle": ticks,
            "axisLabel": ticks,
            "splitLine": {"lineStyle": {"color": "#e6ebef"}},
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


def _centred(signal: Signal) -> NDArray[np.float64]:
    x = signal.samples.astype(np.float64)
    centred: NDArray[np.float64] = x - x.mean(axis=1, keepdims=True)
    return centred


def _top_hz(signal: Signal) -> float:
    half = signal.rate / 2
    return min(half, FELT_HZ[1]) if signal.domain == "time" else half


def _window_of(signal: Signal) -> float:
    """Return how much a column of the spectrogram spans: 32 ms; over displacement a sixteenth of it."""
    return 0.032 if signal.domain == "time" else signal.extent / 16


def _bound(values: NDArray[np.float64], place: int, otherwise: float) -> float:
    return float(values[place]) if len(values) else otherwise


def _digits(value: float) -> float:
    """Return a number with four digits: what a picture shows, and short to send."""
    return float(f"{value:.4g}")


def _nice(value: float) -> float:
    """Return the least of 1, 2, 5 times a power of ten that is at least ``value``."""
    power = 10.0 ** math.floor(math.log10(value))
    return _digits(next(power * step for step in (1, 2, 5, 10) if power * step >= value * (1 - 1e-9)))
