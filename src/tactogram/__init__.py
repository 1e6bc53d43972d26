"""Tactogram learns, generates, judges and renders touch.

The public interface; loaded on first use, so that importing the package costs nothing.

>>> import tactogram
>>> store = tactogram.open_store("surfaces")                    # doctest: +SKIP
>>> run = tactogram.train("stroke_cnn", "surfaces")             # doctest: +SKIP
>>> tactogram.classify(run.folder, tactogram.read_signal("x.wav"))   # doctest: +SKIP
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactogram.datasets import open_store as open_store
    from tactogram.jobs.classify import classify as classify
    from tactogram.jobs.convert import convert as convert
    from tactogram.jobs.crossval import crossval as crossval
    from tactogram.jobs.evaluate import evaluate as evaluate
    from tactogram.jobs.generate import generate as generate
    from tactogram.jobs.search import search as search
    from tactogram.jobs.stream import stream as stream
    from tactogram.jobs.stream_settings import StreamSettings as StreamSettings
    from tactogram.jobs.training import load_run as load_run
    from tactogram.jobs.training import train as train
    from tactogram.rendering.catalogue import open_display as open_display
    from tactogram.rendering.fit import fit as fit
    from tactogram.signal import Signal as Signal
    from tactogram.signal.io import read_signal as read_signal
    from tactogram.signal.io import write_signal as write_signal

_PLACES = {
    "Signal": "tactogram.signal",
    "read_signal": "tactogram.signal.io",
    "write_signal": "tactogram.signal.io",
    "open_store": "tactogram.datasets",
    "train": "tactogram.jobs.training",
    "load_run": "tactogram.jobs.training",
    "crossval": "tactogram.jobs.crossval",
    "evaluate": "tactogram.jobs.evaluate",
    "classify": "tactogram.jobs.classify",
    "search": "tactogram.jobs.search",
    "generate": "tactogram.jobs.generate",
    "convert": "tactogram.jobs.convert",
    "open_display": "tactogram.rendering.catalogue",
    "fit": "tactogram.rendering.fit",
    "stream": "tactogram.jobs.stream",
    "StreamSettings": "tactogram.jobs.stream_settings",
}

__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(_PLACES[name]), name)
    raise AttributeError(f"module 'tactogram' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
