"""The families of displays: which module turns a signal into the drive of each."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Protocol, cast

from pydantic import BaseModel

from tactogram.rendering.displays.display import Display, Family
from tactogram.rendering.level import Level
from tactogram.signal.signal import Signal

MODULES: dict[Family, str] = {
    "linear": "tactogram.rendering.families.linear",
    "ultrasonic": "tactogram.rendering.families.ultrasonic",
    "electrovibration": "tactogram.rendering.families.electrovibration",
    "tablet": "tactogram.rendering.families.tablet",
    "amplitude_stream": "tactogram.rendering.families.amplitude_stream",
    "pattern": "tactogram.rendering.families.pattern",
}


class FamilyModule(Protocol):
    """What a family's module holds, see `tactogram.rendering.displays.display`."""

    Settings: type[BaseModel]

    def drive(
        self, signal: Signal, settings: Any, *, display: Display, level: Level
    ) -> tuple[Signal, dict[str, Any]]:
        """Return the drive of ``signal``, and JSON facts on what was scaled, clipped or cannot be reached."""
        ...


def family_module(family: Family) -> FamilyModule:
    """Return the module of a family, loaded on first use."""
    return cast("FamilyModule", import_module(MODULES[family]))
