"""Materials that an English text describes, by the similarity of sentence embeddings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import MissingExtraError, ParameterError

LEAST_SIMILARITY = 0.3
"""Cosine below which a text describes nothing that is known."""
SHARPNESS = 20.0
"""Inverse temperature of the softmax over cosines that gives the weights."""
LEAST_WEIGHT = 0.1
"""Materials of less weight than this share of the greatest are left out."""
MOST_MATERIALS = 3
"""In a mix."""


def describe(
    text: str, materials: Sequence[str], *, synonyms: Mapping[str, Sequence[str]]
) -> dict[str, float]:
    """Return weights, which sum to 1, of the materials that a text in English describes, the greatest first.

    Names of ``materials`` have hyphens or underscores for spaces; ``synonyms`` are other names, and typical objects, of
    some. Raises `ParameterError` if the text is like no material, `MissingExtraError` without the extra ``text``.
    """
    names = [(name, called) for name in materials for called in (name, *synonyms.get(name, ()))]
    vectors = embedded([text, *(called for _, called in names)])
    similarity = dict.fromkeys(materials, -1.0)
    for (name, _), cosine in zip(names, vectors[1:] @ vectors[0], strict=True):
        similarity[name] = max(similarity[name], float(cosine))
    nearest = sorted(materials, key=lambda name: -similarity[name])
    best = similarity[nearest[0]]
    if best < LEAST_SIMILARITY:
        raise ParameterError.must(
            "text",
            f"describe a material that the model knows, and {text!r} is like none of the {len(materials)}; "
            f"the nearest are {', '.join(nearest[:3])}",
        )
    weights = {
        name: float(np.exp(SHARPNESS * (similarity[name] - best))) for name in nearest[:MOST_MATERIALS]
    }
    kept = {name: weight for name, weight in weights.items() if weight >= LEAST_WEIGHT}
    return {name: round(weight / sum(kept.values()), 4) for name, weight in kept.items()}


def plain(name: str) -> str:
    """Return a name in lower case, with single spaces for hyphens, underscores and spaces."""
    return " ".join(name.replace("-", " ").replace("_", " ").lower().split())


def embedded(texts: Sequence[str]) -> NDArray[np.float32]:
    """Return embeddings of length 1, shape (text, number); 0 of a text without known words."""
    vectors = np.asarray(_encoder().embed([plain(text) for text in texts]), np.float32)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, np.finfo(np.float32).tiny), np.float32)


@cache
def _encoder() -> Any:
    try:
        import wordllama
    except ImportError:
        raise MissingExtraError(
            "descriptions need wordllama, which is not installed: pip install 'tactogram[text]'"
        ) from None
    # Without the folder it does not find the tokenizer that its own package contains.
    folder = Path(wordllama.__file__).parent
    return wordllama.WordLlama.load(cache_dir=folder, disable_download=True)
