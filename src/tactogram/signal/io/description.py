"""Signal description: metadata written with samples so that they are read back unchanged."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from tactogram.errors import DataError, ParameterError
from tactogram.signal.signal import Domain, Signal
from tactogram.text_files import parse_json

VERSION = 1


@dataclass(frozen=True)
class SignalDescription:
    """Everything about a signal but its samples, as one line of JSON in a comment of the file."""

    rate: float  # exact; a WAV header has whole Hz only
    unit: str
    axes: tuple[str, ...]
    domain: Domain = "time"
    full_scale: float | None = None  # value of the largest integer, in unit; for integer samples only
    metadata: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, signal: Signal, metadata: Mapping[str, Any] | None, *, full_scale: float | None = None
    ) -> SignalDescription:
        """Return the description of ``signal``."""
        return cls(signal.rate, signal.unit, signal.axes, signal.domain, full_scale, dict(metadata or {}))

    def encode(self) -> str:
        """Return it as one line of ASCII; `ParameterError` if the metadata is not JSON."""
        facts = {
            "tactogram": VERSION,
            "rate": self.rate,
            "unit": self.unit,
            "axes": self.axes,
            "domain": self.domain,
            "full_scale": self.full_scale,
            "metadata": self.metadata,
        }
        try:
            return json.dumps(facts, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise ParameterError(f"metadata must be JSON values: {error}") from error


def decode(text: str, where: str) -> SignalDescription | None:
    """Return the description in ``text``, or None for a foreign comment; `DataError` if it is damaged or too new."""
    try:
        facts = parse_json(text, where)
    except DataError:
        return None
    if not isinstance(facts, dict) or "tactogram" not in facts:
        return None
    if facts["tactogram"] != VERSION:
        raise DataError(
            f"{where}: description must be of version {VERSION}, got {facts['tactogram']!r}; update"
        )
    try:
        scale = facts["full_scale"]
        return SignalDescription(
            rate=float(facts["rate"]),
            unit=str(facts["unit"]),
            axes=tuple(str(name) for name in facts["axes"]),
            domain=cast("Domain", facts["domain"]),
            full_scale=None if scale is None else float(scale),
            metadata=dict(facts["metadata"]),
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise DataError(f"{where}: description is damaged: {error!r}") from error
