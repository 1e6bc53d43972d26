"""Conditions that models are given: names, checks and weights."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.plugins import entry_point_modules, further_folders, import_plugin, module_files
from tactogram.signal import Image, Signal
from tactogram.signal.motion import Motion

ENTRY_POINTS = "tactogram.conditions"
"""Entry points of installed packages with conditions: ``my_condition = "my_package.my_condition"``."""
VARIABLE = "TACTOGRAM_CONDITIONS"
"""Environment variable with further files of conditions, and folders of such files, separated as in PATH."""
Contactor = Literal["finger", "stylus"]


@dataclass(frozen=True)
class ConditionOption:
    """A way to state a condition as text: an option of the command line, a column of a table, a field of a form.

    Parameters
    ----------
    name : str
        Of the column; with dashes that of the option.
    kind : type
        Of the value: str, float, a Literal, or Mapping[str, float].
    help : str
    read : str
        Function of the value and of the `tactogram.workflows.generation.generate.Reading`, as ``module:name``, that
        returns the condition's value; by default the value itself. Its name is that of the condition in errors.
    file : str
        Key of a generated file's metadata under which the name of the given one is written, if the value is a file.
    example : str
        A value, for messages.
    """

    name: str
    kind: Any = str
    help: str = ""
    read: str = ""
    file: str = ""
    example: str = ""


@dataclass(frozen=True)
class ConditionType:
    """A condition: all that the command line, tables, forms and models' promises say of it is derived from this.

    Parameters
    ----------
    name : str
        In a `Condition`, and in a ``model.toml``.
    help : str
        Its meaning and its type in Python.
    options : tuple of ConditionOption
        Ways to state it, of which one is taken; none if it is for Python alone.
    unit : str
        Of a number; empty for another type.
    types : tuple of type
        Of its value in Python, if it is no number; any type if empty.
    """

    name: str
    help: str
    options: tuple[ConditionOption, ...] = ()
    unit: str = ""
    types: tuple[type, ...] = ()

    @property
    def label(self) -> str:
        """Label of a field: its option and unit, such as ``Speed, mm/s``."""
        words = (self.options[0].name if self.options else self.name).replace("_", " ").capitalize()
        return f"{words}, {self.unit}" if self.unit else words

    def check(self, value: Any) -> None:
        """Refuse a number that is none, and a value of another type; a `ParameterError` names the condition."""
        if self.unit and not (isinstance(value, int | float | np.number) and math.isfinite(value)):
            raise ParameterError.must(self.name, f"be a finite number, {self.unit}", value)
        if self.types and not isinstance(value, self.types):
            names = " or ".join(kind.__name__ for kind in self.types)
            raise ParameterError.must(self.name, f"be {names} ({self.help})", value)


_READ = "tactogram.workflows.generation.generate:"
BUILT_IN = (
    ConditionType(
        "material",
        "weight per material name, e.g. {'cork': 0.6, 'tile': 0.4}; a lone name is weight 1",
        (
            ConditionOption("material", help="material that the model knows", example="NAME"),
            ConditionOption("mix", Mapping[str, float], "weights by material, e.g. A=0.6,B=0.4"),
        ),
        types=(str, Mapping),
    ),
    ConditionType(
        "image",
        "photograph of the surface (Image)",
        (
            ConditionOption(
                "image",
                help="photograph of the surface; also with --text or --words",
                read=_READ + "read_photograph",
                file="photograph",
                example="photo.jpg",
            ),
        ),
        types=(Image,),
    ),
    ConditionType(
        "text",
        "the surface in English, e.g. 'coarse cork', for a model that learned materials by name",
        (ConditionOption("text", help="the surface in English, e.g. 'coarse cork'; with --image, both"),),
        types=(str,),
    ),
    ConditionType(
        "words",
        "score per sensory word, e.g. {'rough': 6.0}",
        (
            ConditionOption(
                "words",
                Mapping[str, float],
                "scores from 1 to 7 by word, e.g. rough=6,sticky=2",
                read=_READ + "read_words",
                example="WORD=SCORE",
            ),
        ),
        types=(Mapping,),
    ),
    ConditionType(
        "vibration",
        "measured vibration of the surface (Signal)",
        (
            ConditionOption(
                "vibration",
                help="recording of the surface",
                read=_READ + "read_recording",
                file="vibration_from",
                example="stroke.wav",
            ),
        ),
        types=(Signal,),
    ),
    ConditionType(
        "speed_mm_s",
        "stroking speed, mm/s",
        (ConditionOption("speed", float, "stroking speed, mm/s"),),
        "mm/s",
    ),
    ConditionType("force_n", "normal force, N", (ConditionOption("force", float, "normal force, N"),), "N"),
    ConditionType(
        "contactor",
        "what strokes the surface: finger or stylus",
        (ConditionOption("contactor", Contactor, "what strokes the surface"),),
    ),
    ConditionType(
        "motion",
        "speed and force of the finger over time (Motion), in place of these two",
        (
            ConditionOption(
                "motion",
                help="motion of the finger instead of --speed and --force: a CSV as for `stream`, or simulated, a hand",
                read=_READ + "read_motion",
                file="motion_from",
            ),
        ),
        types=(Motion,),
    ),
    ConditionType(
        "vibration_speed_mm_s",
        "speed of the measured vibration, mm/s",
        (ConditionOption("vibration_speed", float, "speed of that recording, mm/s"),),
        "mm/s",
    ),
    ConditionType(
        "vibration_force_n",
        "force of the measured vibration, N",
        (ConditionOption("vibration_force", float, "force of that recording, N"),),
        "N",
    ),
    ConditionType(
        "vibration_contactor",
        "what the measured vibration was stroked with: finger or stylus",
        (ConditionOption("vibration_contactor", Contactor, "what stroked in that recording"),),
    ),
    ConditionType(
        "latent",
        "float array, shape (dimension,): the model's random input, to interpolate; by default drawn by the seed",
    ),
)


def condition_types() -> Mapping[str, ConditionType]:
    """Return all conditions by name: built-in ones, those of installed packages, and those in further files.

    Each further module defines ``CONDITION``, a `ConditionType`.

    Raises
    ------
    ParameterError
        If a module defines none, or two conditions, or two of their options, have one name.
    """
    return _conditions(os.environ.get(VARIABLE, ""), tuple(sys.path))


@lru_cache(maxsize=32)
def _conditions(variable: str, path: tuple[str, ...]) -> Mapping[str, ConditionType]:
    files = [file for folder in further_folders(VARIABLE) for file in module_files(folder, "condition")]
    further: list[str | Path] = [*entry_point_modules(ENTRY_POINTS), *files]
    known = {built_in.name: built_in for built_in in BUILT_IN}
    options = {option.name for built_in in BUILT_IN for option in built_in.options}
    for plugin in further:
        kind = getattr(import_plugin(plugin), "CONDITION", None)
        if not isinstance(kind, ConditionType):
            raise ParameterError(f"{plugin}: must define CONDITION, a ConditionType")
        taken = {kind.name} & set(known) or {option.name for option in kind.options} & options
        if taken:
            raise ParameterError(f"{plugin}: rename {min(taken)!r}, which is another condition's")
        known[kind.name] = kind
        options |= {option.name for option in kind.options}
    return known


def check_values(condition: Condition) -> None:
    """Refuse values that are not of their condition's type; a `ParameterError` names the condition."""
    known = condition_types()
    for name, value in condition.items():
        if value is not None and name in known:
            known[name].check(value)


def check_options(values: Mapping[str, Any]) -> None:
    """Refuse values of two options of one condition; a `ParameterError` names them."""
    for kind in condition_types().values():
        stated = [option.name for option in kind.options if values.get(option.name) is not None]
        if len(stated) > 1:
            raise ParameterError(f"must have {' or '.join(stated)}, got both")


def condition_options() -> dict[str, tuple[ConditionType, ConditionOption]]:
    """Return every option with its condition, by the option's name."""
    return {option.name: (kind, option) for kind in condition_types().values() for option in kind.options}


Condition = Mapping[str, Any]

MOST_NAMES = 30
"""Names that a message lists in full."""


def check_condition(condition: Condition, *, needs: Sequence[str] = (), takes: Sequence[str] = ()) -> None:
    """Refuse a condition that lacks a needed name or has one in neither ``needs`` nor ``takes``.

    Raises
    ------
    ParameterError
        Naming the missing or the unknown condition.
    """
    for name in needs:
        if condition.get(name) is None:
            raise ParameterError(f"condition {name!r} is needed: {condition_types()[name].help}")
    for name, value in condition.items():
        if value is not None and name not in (*needs, *takes):
            allowed = ", ".join((*needs, *takes)) or "none"
            raise ParameterError(f"condition {name!r} is not one this model takes ({allowed})")
    check_values(condition)


def check_state(names: Sequence[str], expected: Sequence[str]) -> None:
    """Refuse a saved state of other materials or words.

    Raises
    ------
    ParameterError
        Naming both.
    """
    if tuple(names) != tuple(expected):
        raise ParameterError(f"state is of {', '.join(names)}; expected {', '.join(expected)}")


def material_weights(condition: Condition, materials: Sequence[str]) -> NDArray[np.float64]:
    """Return the weight of each of ``materials`` in ``condition["material"]``.

    Parameters
    ----------
    condition : mapping
        ``material`` is a name or a mapping from name to weight >= 0.
    materials : sequence of str
        Materials of the model.

    Returns
    -------
    float64 array, shape (material,)
        Not scaled to sum to 1.

    Raises
    ------
    ParameterError
        For an unknown material, a weight that is negative or not finite, or weights that are all 0.
    """
    mix = condition.get("material")
    if mix is None:
        raise ParameterError(f"condition 'material' is needed: {condition_types()['material'].help}")
    mix = {mix: 1.0} if isinstance(mix, str) else dict(mix)
    weights = np.zeros(len(materials))
    for name, weight in mix.items():
        if name not in materials:
            raise ParameterError.must(
                "material", f"be {some_of(materials, like=name)}", name, choices=materials
            )
        if not (np.isfinite(weight) and weight >= 0):
            raise ParameterError(f"weight of {name} must be finite and >= 0, got {weight}")
        weights[materials.index(name)] = weight
    if not weights.any():
        raise ParameterError("at least one material needs a weight > 0, got all 0")
    return weights


def contactor_number(name: str) -> float:
    """Return -1 for a finger, 1 for a stylus (a pen, tool or tip of any kind), NaN for other names."""
    words = set(name.lower().replace("-", " ").replace("_", " ").split())
    if words & {"finger", "fingertip", "hand"}:
        return -1.0
    return 1.0 if words & {"stylus", "pen", "tool", "tip", "probe"} else math.nan


def some_of(names: Sequence[str], *, like: str = "") -> str:
    """Return names in words, for a message: of very many those that are spelt most alike."""
    if len(names) <= MOST_NAMES:
        return f"one of {', '.join(names)}"
    alike = get_close_matches(like, names, n=8, cutoff=0.5) or names[:8]
    return f"one of {len(names)}, e.g. {', '.join(alike)}"
