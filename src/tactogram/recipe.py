"""Recipe: model, preparation of the data, configuration and seed of a training."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass, dft321, principal_axis
from tactogram.signal.resampling import resample
from tactogram.text_files import parse_toml, read_toml
from tactogram.validation import validated, with_changes


class Preparation(BaseModel):
    """Preparation of a recording for a model, the same in training, evaluation and use.

    In this order: select ``stream``; cut to ``length``; select ``axes``; band-pass ``band``; resample to ``rate``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    stream: str | None = None
    """Name of the stream; None is ``acceleration`` if there is one, else the first of the data set."""
    length: float | None = Field(default=None, gt=0, le=1e9, allow_inf_nan=False)
    """Length from the beginning that is used, s, or mm over displacement: for takes that end at rest. None is all."""
    axes: Annotated[tuple[str, ...], Field(min_length=1)] | Literal["all", "dft321", "pca", "mean"] = "all"
    """Axes by name, all of them, three combined to one by DFT321, their first principal component, or the mean of all:
    for recordings of one and two channels, as a player with one channel plays them."""
    band: tuple[float, float] | None = None
    """Pass band in Hz (zero-phase); None leaves the signal as it is."""
    rate: Annotated[float, Field(gt=0, le=1e6)] | Literal["own", "band"] = "own"
    """Sampling rate in Hz; ``own`` is the recording's; ``band`` is 2.5 times the upper edge of ``band`` if that is
    lower, which loses nothing that the band-pass left."""

    @field_validator("band")
    @classmethod
    def _band_is_a_band(cls, band: tuple[float, float] | None) -> tuple[float, float] | None:
        if band is not None and not 0 <= band[0] < band[1]:
            raise ValueError(f"band must be low < high in Hz, got {band[0]:g} {band[1]:g}")
        return band

    def stream_of(self, names: Sequence[str]) -> str:
        """Return the stream of ``names`` to prepare; `ParameterError` if the recipe's is not among them."""
        if not names:
            raise ParameterError("there are no recordings, only photographs")
        if self.stream is None:
            return "acceleration" if "acceleration" in names else names[0]
        if self.stream not in names:
            raise ParameterError(f"prepare.stream must be one of {', '.join(names)}, got {self.stream!r}")
        return self.stream

    def apply(self, signal: Signal) -> Signal:
        """Return ``signal`` as a model sees it."""
        if self.length is not None:
            signal = signal.cut(0, max(1, round(self.length * signal.rate)))
        if self.axes == "dft321":
            signal = dft321(signal)
        elif self.axes == "pca":
            signal = principal_axis(signal)
        elif self.axes == "mean":
            signal = signal.with_samples(signal.samples.mean(axis=0), axes=("mean",))
        elif self.axes != "all":
            signal = signal.select(*self.axes)
        if self.band is not None:
            signal = bandpass(signal, *self.band)
        rate = self.rate_of(signal.rate)
        return signal if rate == signal.rate else resample(signal, rate)

    def rate_of(self, own: float) -> float:
        """Return the rate in Hz to which a recording of rate ``own`` is resampled."""
        if isinstance(self.rate, float):
            return self.rate
        if self.rate == "own" or self.band is None:
            return own
        return min(own, 2.5 * self.band[1])


class TrainingSettings(BaseModel):
    """Settings of the training loop; only ``precision`` affects what is learned."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    precision: Literal["32-true", "bf16-mixed", "16-mixed", "auto"] = "32-true"
    """Lightning Fabric's name of the number format; ``auto`` is ``bf16-mixed`` on processors and GPUs that multiply
    bfloat16 faster than float32, ``32-true`` on others."""
    checkpoint_every: int = Field(default=200, gt=0)
    """Steps between checkpoints."""
    log_every: int = Field(default=10, gt=0)
    """Steps between lines of metrics.jsonl."""


class Recipe(BaseModel):
    """Recipe of a training. A file holds only values that differ from the defaults; unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    model: str
    seed: int = Field(default=0, ge=0)
    """Seed of everything random: the split, initial weights, batches."""
    prepare: Preparation = Preparation()
    training: TrainingSettings = TrainingSettings()
    config: dict[str, Any] = Field(default_factory=dict)
    """Values that differ from the model's own `Config`."""

    @classmethod
    def load(cls, path: Path, *, changes: Mapping[str, Any] | None = None) -> Self:
        """Read a TOML file and apply ``changes``, values by dotted key, e.g. ``{"prepare.rate": 2000}``.

        Raises `DataError` if the file is not TOML; `ParameterError` if a key or value is not one of a recipe.
        """
        for key in changes or {}:
            if key.partition(".")[0] not in cls.model_fields:
                raise ParameterError(
                    f"unknown key {key!r}",
                    parameter="changes",
                    remedy="a setting of the model is config.NAME, and others begin with prepare, seed or training: "
                    "`tactogram models MODEL` lists them",
                )
        return cls.of(with_changes(read_toml(path), changes), where=str(path))

    @classmethod
    def of(cls, values: Mapping[str, Any], *, where: str = "recipe") -> Self:
        """Return the recipe that ``values`` describe."""
        return validated(cls, values, where=where)

    def resolved(self, config: BaseModel) -> dict[str, Any]:
        """Return every value that affects the result, defaults included, as JSON types."""
        return self.model_dump(mode="json") | {"config": config.model_dump(mode="json")}


def parse_changes(assignments: Sequence[str], *, option: str = "a change") -> dict[str, Any]:
    """Return assignments such as ``"prepare.rate=2000"`` by dotted key; a value is read as TOML, else as text.

    Raises `ParameterError` if one is no assignment; it names the ``option``.
    """
    changes = {}
    for text in assignments:
        key, sign, value = text.partition("=")
        if not (sign and key.strip()):
            raise ParameterError(f"{option} must be KEY=VALUE, got {text!r}")
        try:
            changes[key.strip()] = parse_toml(f"x = {value}", key)["x"]
        except DataError:
            changes[key.strip()] = value.strip()
    return changes


def run_id(resolved: Mapping[str, Any], data_sha256: str) -> str:
    """Return 10 hex digits that identify a run by everything that affects its result."""
    facts = json.dumps({"recipe": resolved, "data": data_sha256}, sort_keys=True)
    return hashlib.sha256(facts.encode()).hexdigest()[:10]


def dotted(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested values by their names with dots, as ``--set`` takes them."""
    settings: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            settings |= dotted(value, f"{prefix}{name}.")
        else:
            settings[f"{prefix}{name}"] = value
    return settings
