"""Words of an English text: the names that they mention, and the materials that they are most like, by embeddings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import MissingExtraError

SHARPNESS = 20.0
"""Inverse temperature of the softmax over cosines that gives the weights."""
LEAST_WEIGHT = 0.1
"""Materials of less weight than this share of the greatest are left out."""
MOST_MATERIALS = 3
"""In a mix."""
_LINK = re.compile("as|at|by|for|from|in|into|like|of|on|onto|over|through|to|under|with")
_EMPTY = re.compile(
    "a|an|and|any|bit|feel|feeling|feels|i|is|it|its|kind|made|material|my|or|out|piece|some|something|sort|sound|"
    "surface|texture|that|the|this|touch|very|your"
)
"""Words that name nothing; a phrase ends before a link, and its last word is what it is about."""


def content_words(text: str, phrases: Iterable[str]) -> list[list[str]]:
    """Return the words of each phrase of a text in English, without those that name nothing.

    Two words are one where ``phrases`` write them so, such as "heart beat".
    """
    known, parts = {stem(plain(phrase)) for phrase in phrases}, list[list[str]]([[]])
    for word in re.findall(r"\w+", plain(text)):
        if _LINK.fullmatch(word):
            parts.append([])
        elif parts[-1] and stem(parts[-1][-1] + word) in known:
            parts[-1][-1] += word
        elif not _EMPTY.fullmatch(word):
            parts[-1].append(word)
    return [part for part in parts if part]


def stem(word: str) -> str:
    """Return a word without the ending of a plural."""
    return word.removesuffix("s") if len(word) > 3 and not word.endswith("ss") else word


def mentioned(
    words: Iterable[str], names: Mapping[str, Sequence[str]], *, heads: bool = False
) -> dict[str, set[str]]:
    """Return the stems by which words mention each of ``names``.

    A name is mentioned by all words of one of its phrases; with ``heads`` also by the last of its first phrase, as a
    "leather glove" mentions "grained leather", unless another is mentioned as a whole. A mention by fewer of the same
    words is left out: "steel wool" is no wool.
    """
    present = {stem(word) for word in words}
    found, whole = dict[str, set[str]](), set[str]()
    for name, phrases in names.items():
        for number, phrase in enumerate(map(plain, phrases)):
            own = [stem(word) for part in content_words(phrase, ()) for word in part]
            joined = {stem(phrase.replace(" ", ""))} & present
            if joined or (own and {*own} <= present):
                whole.add(name)
            elif not (heads and number == 0 and own and own[-1] in present):
                continue
            found.setdefault(name, set()).update(joined or {*own} & present)
    longest = {name: own for name, own in found.items() if not any(own < other for other in found.values())}
    kept = longest.keys() & whole or longest.keys()
    return {name: own for name, own in longest.items() if name in kept}


def mixed(mentions: Mapping[str, str], *, synonyms: Mapping[str, Sequence[str]]) -> dict[str, float]:
    """Return weights, which sum to 1, of materials by how like their names the words are that mention each.

    The greatest is first. ``synonyms`` are other names, and typical objects, of some. Raises `MissingExtraError` for
    several materials without the extra ``text``.
    """
    if len(mentions) == 1:
        return dict.fromkeys(mentions, 1.0)
    similarity = {}
    for name, words in mentions.items():
        said, *called = embedded([words, name, *synonyms.get(name, ())])
        similarity[name] = float(np.max(called @ said))
    nearest = sorted(mentions, key=lambda name: -similarity[name])
    weights = {
        name: float(np.exp(SHARPNESS * (similarity[name] - similarity[nearest[0]])))
        for name in nearest[:MOST_MATERIALS]
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
