"""Labels of a study's settings and their choices in the editor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pydantic import BaseModel

from tactogram_study.designs import Design

LABELS: Mapping[str, str] = {
    "title": "Title",
    "source": "Publication that is reproduced",
    "consent": "Consent text",
    "seed": "Seed",
    "order": "Order of the trials",
    "rest_every": "Offer a rest after this many trials (0: never)",
    "display": "Display",
    "played_by": "Played by",
    "level": "Level",
    "alpha": "Alpha",
    "instructions": "Text above each trial",
    "speed_mm_s": "Speed of the finger, mm/s",
    "low": "Lowest value",
    "high": "Highest value",
    "low_text": "Text at the lower end",
    "high_text": "Text at the upper end",
    "id": "Name in the tables of answers",
    "kind": "Kind of answer",
    "text": "Text",
    "required": "Must be answered",
    "trials": "Trials of practice",
    "feedback": "Show after each answer whether it was right",
    "right": "After a right answer",
    "wrong": "After a wrong answer",
    "ended": "At the end of the practice",
    "name": "Name",
    "item": "Item",
    "condition": "Condition",
    "seconds": "Length, s",
    "material": "Material",
    "autoregressive": "Replace it by a signal from an autoregressive model of it",
    "reconstructed": "Convert it to a spectrogram and back",
    "axes": "Axes",
    "count": "Number of items",
}
"""By the setting's key; other keys are shown with spaces."""
CHOICES: Mapping[str, Mapping[str, str]] = {
    "order": {
        "random": "all trials in one random order",
        "blocks": "each repeat in its own random order",
        "latin": "Latin square over participants",
        "williams": "Williams design over participants",
        "as-listed": "as listed",
    },
    "played_by": {
        "browser": "the participant's browser, as sound",
        "server": "a display at this machine",
        "stream": "a display at this machine, following the finger",
    },
    "kind": {
        "choice": "one of several options",
        "steps": "a scale of steps",
        "vas": "a line without marks",
        "number": "a number",
        "text": "free text",
    },
    "given": {
        "speed_mm_s": "Given the speed, mm/s",
        "force_n": "Given the force, N",
        "vibration_speed_mm_s": "Speed of the recording, mm/s",
        "vibration_force_n": "Force of the recording, N",
    },
    "reconstructed": {"griffin_lim": "phase by Griffin-Lim", "phase_gradient": "phase by its gradient"},
}
"""By the setting's key and the value."""


def label_of(model: type[BaseModel], key: str) -> str:
    """Return a setting's label: the title of its field, if it has one."""
    field = model.model_fields.get(key)
    return (field and field.title) or LABELS.get(key) or key.replace("_", " ").capitalize()


def choices_of(model: type[BaseModel], key: str, values: Sequence[str]) -> dict[str, str]:
    """Return the titles of a setting's choices by value."""
    own = model.labels if issubclass(model, Design) else {}
    titles = CHOICES.get(key, {})
    return {value: own.get(f"{key}.{value}") or titles.get(value, value) for value in values}
