"""Choice of a model: the one that measured best for what it is for (docs/results.md)."""

from __future__ import annotations

from tactogram.datasets import Label, Store
from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal.modulated_noise import LEAST_RATE

FLOW = "texture_flow"
FLOW_LEAST_RATE = 230.0
"""Rate from which its windows have enough bins, Hz."""
_NEEDED = {"photograph": "photographs", "words": "ratings", "rating": "ratings"}


def model_choice(purpose: str, store: Store, *, label: Label = "material") -> tuple[str, str, str]:
    """Return the name of the model to train on ``store``, that of its recipe, and why, with what is for the rest.

    Raises
    ------
    ParameterError
        If it is for photographs, words or ratings, and the store has none.
    """
    has = {"photograph": bool(store.photographs_by_material), "words": store.ratings is not None}
    if not (has | {"rating": has["words"]}).get(purpose, True):
        problem = f"{purpose} needs a store with {_NEEDED[purpose]}, {store.path} has none"
        raise ParameterError(problem, parameter="purpose")
    if purpose == "recognition":
        return "stroke_statistics", "quick", "names surfaces as well as stroke_cnn, in seconds"
    if purpose == "rating":
        return "rater", "quick", "predicts the ratings of recordings or photographs in sensory words"
    if not len(store):
        return FLOW, "image", "generates images, from any words"
    first = store.index[0].id
    stream = Preparation().stream_of(store.streams_of(first))
    if store.streams[stream].domain == "displacement":
        return FLOW, "friction", "generates signals over displacement"
    if purpose != "generate":
        recipe = "rated" if purpose == "words" and label == "item" else "quick"
        return FLOW, recipe, "takes photographs and words; of a material by its name, texture_var is closer"
    if (rate := store.rate(first, stream)) < LEAST_RATE:
        model = FLOW if rate >= FLOW_LEAST_RATE else "ar_texture"
        return model, "quick", f"learns from recordings below {LEAST_RATE:g} Hz, too"
    plural = {"photograph": "photographs", "words": "words"}
    others = ", ".join(["other speeds and forces", *(plural[name] for name, held in has.items() if held)])
    return "texture_var", "quick", f"closest to recordings of a known material; {FLOW} also takes {others}"
