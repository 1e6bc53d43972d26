"""Tactile signals: the type, filters, synthesis, perception; numpy and scipy only. Files are in `tactogram.signal.io`.

The functions are loaded on first use: scipy's filters take longer to import than a stimulus to play.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tactogram.signal.signal import UNITS as UNITS
from tactogram.signal.signal import Image as Image
from tactogram.signal.signal import Signal as Signal

if TYPE_CHECKING:
    from tactogram.signal.filters import StreamBandpass as StreamBandpass
    from tactogram.signal.filters import bandpass as bandpass
    from tactogram.signal.filters import dft321 as dft321
    from tactogram.signal.filters import remove_gravity as remove_gravity
    from tactogram.signal.kinematics import differentiate as differentiate
    from tactogram.signal.kinematics import integrate as integrate
    from tactogram.signal.perception import detection_threshold as detection_threshold
    from tactogram.signal.perception import sensation_level_db as sensation_level_db
    from tactogram.signal.perception import weighted as weighted
    from tactogram.signal.resampling import resample as resample
    from tactogram.signal.timing import SamplingTiming as SamplingTiming
    from tactogram.signal.timing import estimate_timing as estimate_timing
    from tactogram.signal.timing import to_uniform as to_uniform

_PLACES = {
    "StreamBandpass": "tactogram.signal.filters",
    "bandpass": "tactogram.signal.filters",
    "dft321": "tactogram.signal.filters",
    "remove_gravity": "tactogram.signal.filters",
    "differentiate": "tactogram.signal.kinematics",
    "integrate": "tactogram.signal.kinematics",
    "detection_threshold": "tactogram.signal.perception",
    "sensation_level_db": "tactogram.signal.perception",
    "weighted": "tactogram.signal.perception",
    "resample": "tactogram.signal.resampling",
    "SamplingTiming": "tactogram.signal.timing",
    "estimate_timing": "tactogram.signal.timing",
    "to_uniform": "tactogram.signal.timing",
}


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(_PLACES[name]), name)
    raise AttributeError(f"module 'tactogram.signal' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
