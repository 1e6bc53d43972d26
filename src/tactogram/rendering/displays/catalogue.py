"""Displays from TOML files: by name those that come with the package, by path any other."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import FAMILIES, display_family
from tactogram.rendering.displays.response import read_response
from tactogram.text_files import read_toml
from tactogram.validation import validated, with_changes

FOLDER = Path(__file__).parent


def shipped() -> dict[str, Path]:
    """Return the files of the displays that come with the package, by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def open_display(name: str | Path, *, changes: Mapping[str, Any] | None = None) -> Display:
    """Return a display by the name of a shipped one, or by the path of its TOML file.

    ``changes`` replace the file's values by dotted key, such as ``{"limit": 2.0, "linear.cap_db": 10}``. Raises
    `DataError` if there is no such file, or it is not TOML; `ParameterError` if a name is unknown, or a key or value
    is not valid for a display or its family.
    """
    known = shipped()
    path = known.get(str(name), Path(name))
    if path.suffix != ".toml":
        raise ParameterError(f"display must be one of {', '.join(known)}, or a TOML file, got {str(name)!r}")
    return display_of(with_changes(read_toml(path), changes), where=str(path), folder=path.parent)


def display_of(values: Mapping[str, Any], *, where: str = "display", folder: Path = Path()) -> Display:
    """Return the display for a file's ``values``: the keys of `Display`, and the family's settings under its name.

    ``where`` is a prefix of errors, ``folder`` that of the response's file. Raises `DataError` if the response's file
    cannot be read; `ParameterError` if a key or value is wrong.
    """
    values = dict(values)
    family = values.get("family")
    if not isinstance(family, str) or family not in FAMILIES:
        raise ParameterError(f"{where}: family must be one of {', '.join(FAMILIES.names())}, got {family!r}")
    if "settings" in values:
        raise ParameterError(f"{where}: the settings of a {family} display belong in a table [{family}]")
    own = values.pop(family, {})
    if not isinstance(own, Mapping):
        raise ParameterError(f"{where}: [{family}] must be a table, got {own!r}")
    settings = validated(display_family(family).settings, own, where=f"{where}: {family}")
    response = values.get("response")
    if isinstance(response, Mapping) and isinstance(response.get("file"), str):
        points = read_response(folder / response["file"])
        rest = {key: value for key, value in response.items() if key != "file"}
        values["response"] = {**rest, "points": points}
    return validated(Display, {**values, "settings": settings}, where=where)
