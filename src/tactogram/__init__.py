"""Tactogram learns, generates, evaluates and renders touch.

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
    from tactogram.rendering.displays.catalogue import open_display as open_display
    from tactogram.rendering.drive.fit import fit as fit
    from tactogram.rendering.ready_effects import effect as effect, effects as effects
    from tactogram.signal import Signal as Signal
    from tactogram.signal.io import read_signal as read_signal, write_signal as write_signal
    from tactogram.signal.motion import Motion as Motion
    from tactogram.workflows.data.convert import convert as convert
    from tactogram.workflows.evaluation.crossval import crossval as crossval
    from tactogram.workflows.evaluation.evaluate import evaluate as evaluate
    from tactogram.workflows.generation.generate import generate as generate
    from tactogram.workflows.pipeline import pipeline as pipeline
    from tactogram.workflows.recognition.classify import classify as classify
    from tactogram.workflows.recognition.search import search as search
    from tactogram.workflows.training.loaded_run import load_run as load_run
    from tactogram.workflows.training.train import train as train

_PLACES = {
    "Signal": "tactogram.signal",
    "Motion": "tactogram.signal.motion",
    "read_signal": "tactogram.signal.io",
    "write_signal": "tactogram.signal.io",
    "open_store": "tactogram.datasets",
    "train": "tactogram.workflows.training.train",
    "load_run": "tactogram.workflows.training.loaded_run",
    "crossval": "tactogram.workflows.evaluation.crossval",
    "evaluate": "tactogram.workflows.evaluation.evaluate",
    "classify": "tactogram.workflows.recognition.classify",
    "search": "tactogram.workflows.recognition.search",
    "generate": "tactogram.workflows.generation.generate",
    "pipeline": "tactogram.workflows.pipeline",
    "convert": "tactogram.workflows.data.convert",
    "open_display": "tactogram.rendering.displays.catalogue",
    "fit": "tactogram.rendering.drive.fit",
    "effect": "tactogram.rendering.ready_effects",
    "effects": "tactogram.rendering.ready_effects",
}

__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(_PLACES[name]), name)
    if name == "__version__":
        from importlib.metadata import version  # takes longer than the rest of this module

        return version("tactogram")
    raise AttributeError(f"module 'tactogram' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
