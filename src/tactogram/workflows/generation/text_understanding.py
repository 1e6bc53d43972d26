"""Understanding of a text in English: the ready effect or materials that it names, and its other words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches

from tactogram.datasets.everyday import SYNONYMS
from tactogram.errors import ParameterError
from tactogram.features.text_classifier import content_words, mentioned, mixed, plain, stem
from tactogram.rendering.ready_effects import effects


@dataclass(frozen=True)
class Understanding:
    """An ``effect`` that a text names, or else weights by ``material``; ``unknown`` are its other words."""

    effect: str = ""
    material: Mapping[str, float] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return it in a line."""
        mix = [f"{name} {weight:g}" if weight < 1 else name for name, weight in self.material.items()]
        named = self.effect or ", ".join(mix)
        parts = {"understood": named, "not understood": ", ".join(self.unknown)}
        return "; ".join(f"{title}: {said}" for title, said in parts.items() if said)


def understand(text: str, materials: Sequence[str]) -> Understanding:
    """Return what a text in English names of the ready effects and of ``materials``, which may be nothing.

    What its first phrase is about decides: "rain on a tent" is the effect, "a tent in the rain" the material. Raises
    `MissingExtraError` if it names several materials, without the extra ``text``.

    >>> str(understand("wet sandpaper", ["sandpaper", "cork"])), understand("a heart beat", []).effect
    ('understood: sandpaper; not understood: wet', 'heartbeat')
    """
    surfaces = {name: (name, *SYNONYMS.get(name, ())) for name in materials}
    actions = {name: (ready.title, *ready.also) for name, ready in effects().items()}
    called = [each for phrases in (*surfaces.values(), *actions.values()) for each in phrases]
    parts = content_words(text, called)
    words = [word for part in parts for word in part]
    surface, action = mentioned(words, surfaces, heads=True), mentioned(words, actions)
    stroked = set[str]().union(*surface.values())
    known = stroked.union(*action.values())
    about = next(filter(None, ([w for w in map(stem, part) if w in known] for part in parts)), None)
    if about is None:
        return Understanding(unknown=_others(words, known))
    if effect := next((name for name, stems in action.items() if about[-1] in stems - stroked), ""):
        return Understanding(effect, unknown=_others(words, action[effect]))
    mentions = {
        name: " ".join(word for word in words if stem(word) in stems)
        for name, stems in surface.items()
        if stems & {*about}
    }
    material = mixed(mentions, synonyms=SYNONYMS)
    return Understanding(
        "", material, _others(words, set[str]().union(*(surface[name] for name in material)))
    )


def material_in(text: str, materials: Sequence[str]) -> Mapping[str, float]:
    """Return weights of the materials that a text in English names; `ParameterError` if it names none."""
    understood = understand(text, materials)
    if understood.effect:
        command = f"`tactogram effect {understood.effect} --out FILE` writes it"
        raise ParameterError(f"{text!r} is an effect, no material", parameter="text", remedy=command)
    if not understood.material:
        near = get_close_matches(plain(text), [*materials, *effects()], n=3) or [*materials[:1], "heartbeat"]
        wanted = f"name a material or an effect that is known, e.g. {' or '.join(near)}"
        raise ParameterError.must("text", wanted, text)
    return understood.material


def _others(words: Sequence[str], known: set[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(word for word in words if stem(word) not in known))
