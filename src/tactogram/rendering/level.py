"""Level of a drive: how strong the output should be, always stated and never guessed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, cast, get_args

from tactogram.errors import ParameterError

Kind = Literal["physical", "sensation", "gain", "peak"]
KINDS = ("physical", "sensation", "sensation=DB", "gain=FACTOR", "peak=SHARE")

MOST_DB, MOST_GAIN = 200.0, 1e12
"""Larger values are mistakes, and would overflow."""


@dataclass(frozen=True)
class Level:
    """Requested strength of a display's output.

    Parameters
    ----------
    kind : {"physical", "sensation", "gain", "peak"}
        - ``physical``: the output equals the signal, in its own unit.
        - ``sensation``: the output is as far above the detection threshold as the signal, or ``value`` dB above it
          (`tactogram.signal.perception.sensation_level_db`). The frequencies that the display can render compensate
          for the others.
        - ``gain``: the output is ``value`` times the signal, in units of output per unit of signal.
        - ``peak``: the largest drive is ``value`` times the display's limit. The signal's own strength is lost; for
          signals without a physical level.
    value : float, optional
        dB, factor or share.

    Raises
    ------
    ParameterError
        If a value is missing or out of range.
    """

    kind: Kind
    value: float | None = None

    def __post_init__(self) -> None:
        value = self.value
        if value is not None and not math.isfinite(value):
            raise ParameterError(f"a level's value must be finite, got {value}")
        match self.kind:
            case "physical" if value is not None:
                raise ParameterError(f"level physical takes no value, got {value:g}; use gain={value:g}")
            case "sensation" if value is not None and abs(value) > MOST_DB:
                raise ParameterError(f"level sensation takes -{MOST_DB:g} to {MOST_DB:g} dB, got {value:g}")
            case "gain" if value is None or not 1 / MOST_GAIN <= value <= MOST_GAIN:
                needed = f"level gain needs a factor of {1 / MOST_GAIN:g} to {MOST_GAIN:g}, got {value}"
                raise ParameterError(f"{needed}; write gain=2")
            case "peak" if value is None or not 0 < value <= 1:
                raise ParameterError(f"level peak needs a share in 0 to 1, got {value}; write peak=0.8")

    def __str__(self) -> str:
        return self.kind if self.value is None else f"{self.kind}={self.value:g}"

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        return {"kind": self.kind, "value": self.value, "asked": str(self)}


def parse_level(text: str) -> Level:
    """Return the level for a text such as ``"sensation=20"``, one of `KINDS`; `ParameterError` for others."""
    kind, sign, number = (part.strip() for part in text.partition("="))
    if kind not in get_args(Kind):
        raise ParameterError.one_of("level", KINDS, text)
    try:
        value = float(number) if sign else None
    except ValueError:
        raise ParameterError(f"level {kind} needs a number after =, got {number!r}") from None
    return Level(cast("Kind", kind), value)
