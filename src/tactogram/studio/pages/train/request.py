"""Training request of the form, as the command line takes it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from tactogram.datasets import Label
from tactogram.datasets.splits.split import By
from tactogram.errors import ParameterError
from tactogram.models import ModelInfo
from tactogram.recipe import parse_changes
from tactogram.workflows.training.plan import TrainingRequest

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,79}")
SPLITS = {
    "": "a part kept apart, drawn",
    "last": "the last of each material kept apart",
    "all": "nothing kept apart",
}
"""Ways of splitting."""
SPLIT_TEXTS = {
    "": "A fifth of the recordings of each material is kept for testing, a tenth for validation: each needs at least "
    "three. With fewer, choose another split.",
    "last": "The last recordings of each material are kept for testing, and one before them for validation where there "
    "are enough.",
    "all": "All is learned from: it cannot be evaluated on its own data.",
}
"""What each does, and asks of the data."""
BYS = {
    "recording": "recording",
    "session": "session: none on two sides",
    "subject": "subject: none on two sides",
    "material": "material: new ones are tested",
    "condition": "condition (speed and force): none on two sides",
}
"""What must not stand on two sides."""


@dataclass(frozen=True)
class RunRequest:
    """A training that somebody wants.

    Parameters
    ----------
    model, data, recipe : str
        ``data`` relative to the workspace.
    name : str
        Of the run: it comes to lie in ``runs/NAME``.
    split : str
        A key of `SPLITS`.
    last : int
        Of split ``last``: how many recordings of each material.
    by, label, where : str
        ``where`` is ``KEY=VALUE``, several parted by spaces.
    changes : tuple of str
        ``KEY=VALUE`` each.
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
    def run(self) -> str:
        """The folder, relative to the workspace.

        Raises
        ------
        ParameterError
            If the name is none for a folder.
        """
        if not NAME.fullmatch(self.name):
            raise ParameterError(
                f"the run's name must be letters, digits, '.', '_' and '-', at most 80, got {self.name[:100]!r}"
            )
        return f"runs/{self.name}"

    @property
    def arguments(self) -> list[str]:
        """What ``tactogram`` is given."""
        found = ["train", self.model, "--data", self.data, "--recipe", self.recipe]
        for option, value, usual in (
            ("--split", self._split, ""),
            ("--by", self.by, "recording"),
            ("--label", self.label, "material"),
        ):
            if value != usual:
                found += [option, value]
        for key, value in self._where.items():
            found += ["--where", f"{key}={value}"]
        for change in self.changes:
            found += ["--set", change]
        return [*found, "--out", self.run]

    def asked(self, data: Path) -> TrainingRequest:
        """Return what the jobs are asked for, of the data set in ``data``."""
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
        found = {}
        for text in self.where.split():
            key, sign, value = text.partition("=")
            if not (sign and key and value):
                raise ParameterError(f"only recordings with: needs KEY=VALUE, got {text!r}")
            found[key] = value
        return found


def describe_model(facts: ModelInfo) -> str:
    """Return what a model is, as two sentences."""
    authors = facts.authors[0] + (" et al." if len(facts.authors) > 1 else "")
    does = {
        "classification": "Names the material of a signal",
        "generation": f"Generates {'an image' if facts.gives == 'image' else 'signals'}",
        "prediction": "Scores signals or images in words",
    }[facts.task]
    asked = [*facts.needs, *(f"{name} (if given)" for name in facts.takes if name != "latent")]
    goes_by = f", going by {_listed(asked)}" if asked and facts.task == "generation" else ""
    learns = {
        "recordings": "recordings of materials" + (" with photographs" if "image" in facts.needs else ""),
        "ratings": "people's scores of signals or images",
        "images": "rated images",
        "both": "rated surfaces and rated signals",
    }[facts.learns_from]
    return f"{does}{goes_by}; learns from {learns}. {authors} {facts.year}: {facts.title}."


def _listed(names: list[str]) -> str:
    names = [name.replace("speed_mm_s", "speed").replace("force_n", "force") for name in names]
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + " and " + names[-1]
