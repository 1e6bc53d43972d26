"""State that is saved: the attributes that a class names, and those of the parts it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from tactogram.model.conditions import check_state


class Saved:
    """An object whose attributes in ``saved`` are its state: nested dicts and lists of tensors, arrays and JSON values.

    An attribute is a number, an array, a tensor, a list or dict of these, a network, or another object with a state.
    A tuple of names, as of materials, is only compared: a state is refused if its names are others. What is None takes
    any value.
    """

    saved: ClassVar[tuple[str, ...]] = ()
    """Attributes of the state; ``"key=attribute"`` where the state has another name."""

    def state(self) -> dict[str, Any]:
        """Return the state."""
        return {key: _state_of(getattr(self, name)) for key, name in self._named()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from ``state``."""
        for key, name in self._named():
            known, value = getattr(self, name), state[key]
            if isinstance(known, tuple):
                check_state(value, known)
            elif hasattr(known, "load_state_dict"):
                known.load_state_dict(value)
            elif hasattr(known, "load_state"):
                known.load_state(value)
            else:
                setattr(self, name, _of_type(known, value))

    def _named(self) -> list[tuple[str, str]]:
        return [(each.split("=")[0], each.split("=")[-1]) for each in self.saved]


def _state_of(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    if hasattr(value, "state_dict"):
        return value.state_dict()
    return value.state() if hasattr(value, "state") else value


def _of_type(known: Any, value: Any) -> Any:
    """Return a saved value as the attribute that it replaces is; arrays come back from a file as tensors."""
    if isinstance(known, np.ndarray):
        return np.asarray(value, known.dtype)
    simple = value is not None and isinstance(known, bool | int | float | str | list)
    return type(known)(value) if simple else value
