"""Training request of the form, and its equivalent command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from tactogram.datasets import By, Label
from tactogram.errors import ParameterError
from tactogram.models import ModelInfo
from tactogram.recipe import parse_changes
from tactogram.workflows import TrainingRequest
from tactogram_studio.tasks.queue import output_name
from tactogram_studio.workspace.commands import arguments

SPLITS = {
    "": "random validation and test parts",
    "last": "last recordings of each material as test part",
    "blocks": "last fifth of every recording as test part",
    "all": "no test part",
}
SPLIT_TEXTS = {
    "": "Of each material, a fifth of the recordings is used for testing and a tenth for validation. This needs at "
    "least three recordings of each; with fewer, choose another split.",
    "last": "The last recordings of each material are used for testing and, where there are enough, the one before "
    "them for validation.",
    "blocks": "Every recording is divided: its last fifth is used for testing, one window after the rest. This is for "
    "single long recordings of each material; it says nothing about another recording of it.",
    "all": "All recordings are used for training: the run cannot be evaluated on its own data.",
}
"""Explanation of each split."""
GROUPINGS = {
    "recording": "single recordings",
    "session": "recordings of a session",
    "subject": "recordings of a subject",
    "material": "recordings of a material (tests unseen materials)",
    "condition": "recordings of a condition (speed and force)",
}
"""Groups of recordings that a split never divides."""


@dataclass(frozen=True)
class RunRequest:
    """A training as entered in the form.

    ``data`` is relative to the workspace, ``split`` a key of `SPLITS`, and ``last`` the number of test recordings of
    each material. ``where`` has conditions ``KEY=VALUE`` separated by spaces.
    """

    model: str
    data: str
    recipe: str
    name: str
    split: str = ""
    last: int = 2
    by: str = "recording"
    label: str = "material"
    where: str = ""
    changes: tuple[str, ...] = ()

    @property
    def folder(self) -> str:
        """The run folder relative to the workspace; raise `ParameterError` if ``name`` is not a folder name."""
        return output_name("runs", self.name)

    @property
    def arguments(self) -> list[str]:
        """The arguments of ``tactogram``."""
        options = {
            "--data": self.data,
            "--recipe": self.recipe,
            "--split": self._split,
            "--by": self.by if self.by != "recording" else "",
            "--label": self.label if self.label != "material" else "",
            "--where": [f"{key}={value}" for key, value in self._where.items()],
            "--set": self.changes,
            "--out": self.folder,
        }
        return arguments("train", self.model, options=options)

    def training_request(self, data: Path) -> TrainingRequest:
        """Return the request as `workflows.training` takes it, for the store in ``data``."""
        return TrainingRequest(
            self.model,
            data,
            recipe=self.recipe,
            changes=parse_changes(self.changes),
            split=self._split,
            by=cast(By, self.by),
            label=cast(Label, self.label),
            where=self._where,
        )

    @property
    def _split(self) -> str:
        return f"last={int(self.last)}" if self.split == "last" else self.split

    @property
    def _where(self) -> Mapping[str, str]:
        conditions = {}
        for text in self.where.split():
            key, sign, value = text.partition("=")
            if not (sign and key and value):
                raise ParameterError(f"the filter must be KEY=VALUE, got {text!r}")
            conditions[key] = value
        return conditions


def describe_model(model: ModelInfo) -> str:
    """Return what a model does, what it learns from, and its paper."""
    tasks = "; or ".join(_described(face) for face in model.faces)
    authors = model.authors[0] + (" et al." if len(model.authors) > 1 else "")
    return f"{tasks[0].upper()}{tasks[1:]}. {authors} {model.year}: {model.title}."


def _described(model: ModelInfo) -> str:
    task = {
        "classification": "classifies the material of a signal",
        "generation": f"generates {'an image' if model.gives == 'image' else 'signals'}",
        "prediction": "predicts word ratings of signals or images",
    }[model.task]
    inputs = [
        *model.needs,
        *(f"{name} (optional)" for name in model.takes if name != "latent" and "vibration_" not in name),
    ]
    given = f" from {_listed(inputs)}" if inputs and model.task == "generation" else ""
    data = {
        "recordings": "recordings of materials" + (" with photographs" if "image" in model.needs else ""),
        "ratings": "people's ratings of signals or images",
        "images": "rated images",
        "both": "rated surfaces and rated signals",
    }[model.learns_from]
    return f"{task}{given}; learns from {data}"


def _listed(names: list[str]) -> str:
    names = [name.replace("speed_mm_s", "speed").replace("force_n", "force") for name in names]
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]
