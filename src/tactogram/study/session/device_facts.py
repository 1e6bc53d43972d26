"""Device facts of a participant: pixels per mm, refresh rate, measured speeds, audio latency.

A page sends them. Invalid ones are dropped: no answer is lost because a browser sends something odd.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.text_files import read_toml

FACT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""Name of a fact: letters, digits and _; it ends with the unit, and after that the slot."""
MOST_FACTS = 40
LONGEST_TEXT = 200
LONGEST_LIST = 200
COLUMN = "device_"
"""Prefix of the columns of an answer's device facts."""
DESCRIPTIONS: Mapping[str, Mapping[str, str]] = read_toml(Path(__file__).with_name("columns.toml"))
"""Descriptions of columns: of ``answers``, of ``device`` facts, and of the tables of ``people`` and notes."""


def valid_facts(device: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the valid facts: numbers, texts, booleans, lists of numbers; nested ones as ``outer_inner``."""
    facts: dict[str, Any] = {}
    for name, value in (device or {}).items():
        entries = value.items() if isinstance(value, Mapping) else [("", value)]
        for key, entry in entries:
            whole = f"{name}_{key}" if key else str(name)
            if FACT.fullmatch(whole) and len(facts) < MOST_FACTS and (valid := _valid(entry)) is not None:
                facts[whole] = valid
    return facts


def device_columns(facts: Mapping[str, Any]) -> dict[str, str]:
    """Return the facts of an answer as extra columns of its row."""
    return {f"{COLUMN}{name}": fact_text(value) for name, value in facts.items()}


def fact_text(value: Any) -> str:
    """Return a fact as the text of a cell; the numbers of a list are separated by spaces."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return " ".join(fact_text(number) for number in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def fact_description(name: str) -> str:
    """Return the description of a fact; of an unknown one, that the page sent it."""
    known = DESCRIPTIONS["device"]
    if name in known:
        return known[name]
    whole, _, slot = name.rpartition("_")
    if slot.upper() in ("A", "B", "X") and whole in known:
        return f"{known[whole]}; of {slot.upper()}"
    return f"{name}, as the page sent it"


def _valid(value: Any) -> Any:
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        # Not math.isfinite: it fails for integers too large for a float. NaN and infinity are not below.
        return value if abs(value) < 1e15 else None
    if isinstance(value, str):
        text = " ".join("".join(c if c.isprintable() else " " for c in value).split())
        return text[:LONGEST_TEXT] or None
    if isinstance(value, list) and 0 < len(value) <= LONGEST_LIST:
        numbers = [_valid(number) for number in value if isinstance(number, int | float)]
        return numbers if len(numbers) == len(value) and None not in numbers else None
    return None
