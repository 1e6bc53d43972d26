"""Language files: the texts of participants' pages and of designs, one TOML file per language.

A file ``nl.toml`` holds texts by key, the keys of ``languages/en.toml``. Those of the package are extended by the files
and folders of ``TACTOGRAM_LANGUAGES``, key by key. A missing text is that of English.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import Field

from tactogram.errors import ParameterError, shown
from tactogram.plugins import further_folders
from tactogram.text_files import read_toml
from tactogram_study import languages as _languages
from tactogram_study.wording import ALL, TAG, Wording

FOLDERS_VARIABLE = "TACTOGRAM_LANGUAGES"
"""Environment variable with files and folders of further language files, separated as in PATH."""
ENGLISH = "en"
Texts = Mapping[str, str]


def language_texts() -> Mapping[str, Texts]:
    """Return the texts of each language by key, without those that are missing.

    Raises `ParameterError` if a file is not named after a language, or has a text that no page shows or that is not
    filled in like the English one; `DataError` if it cannot be read.
    """
    own = (path.resolve() for place in further_folders(FOLDERS_VARIABLE) for path in _files(place))
    return _texts(tuple((path, path.stat().st_mtime_ns, path.stat().st_size) for path in own))


def default_text(key: str) -> Wording:
    """Return a text in every language; English stands for those without it."""
    files = language_texts()
    known = {language: texts[key] for language, texts in files.items() if key in texts}
    return Wording(known | {ALL: files[ENGLISH][key]})


def text_field(key: str) -> Any:
    """Return a model's field that is by default the text of a key."""
    return Field(default_factory=lambda: default_text(key))


def own_name(language: str) -> str:
    """Return the name of a language in itself, ``Deutsch``; its tag if no file has it."""
    return _known(language).get("name", language)


def complete_texts(language: str) -> dict[str, str]:
    """Return every text in a language, those that are missing in English."""
    return {**language_texts()[ENGLISH], **_known(language), "name": own_name(language)}


def missing_texts(language: str) -> tuple[str, ...]:
    """Return the keys that a language's files lack, and whose texts are English."""
    return tuple(key for key in language_texts()[ENGLISH] if key not in _known(language))


def _known(language: str) -> Texts:
    """Return the texts of a language, or those of ``pt`` for ``pt-BR``; none if there is no file of either."""
    files = language_texts()
    return files.get(language) or files.get(language.partition("-")[0]) or {}


@lru_cache(maxsize=8)
def _texts(own: tuple[tuple[Path, int, int], ...]) -> Mapping[str, Texts]:
    """Return the texts of the package and of one's own files, whose times and sizes are keys of the cache."""
    [package] = map(Path, _languages.__path__)
    english = read_toml(package / "en.toml")
    found: dict[str, dict[str, str]] = {}
    for path in (*_files(package), *(path for path, _, _ in own)):
        found.setdefault(path.stem, {}).update(_checked(read_toml(path), english, path))
    return found


def _files(place: Path) -> list[Path]:
    paths = [place] if place.is_file() else sorted(place.glob("*.toml"))
    if not paths:
        raise ParameterError(
            f"{place}: must be a language file such as nl.toml or a folder of such files, found none"
        )
    for path in paths:
        if not re.fullmatch(TAG, path.stem):
            raise ParameterError(f"{path}: must be named after a language tag, as nl.toml or pt-BR.toml")
    return paths


def _checked(texts: Mapping[str, Any], english: Texts, path: Path) -> Texts:
    for key, text in texts.items():
        if key not in english:
            raise ParameterError(f"{path}: unknown key {key!r}; the keys are those of `study languages en`")
        if not isinstance(text, str) or not text.strip():
            raise ParameterError(f"{path}: {key} must be a text, got {shown(text)}")
        if (has := _filled_in(text)) != (needs := _filled_in(english[key])):
            raise ParameterError(f"{path}: {key} must contain {_listed(needs)}, got {_listed(has)}")
    return texts


def _filled_in(text: str) -> list[str]:
    return sorted(set(re.findall(r"\{\w+\}", text)))


def _listed(names: list[str]) -> str:
    return " and ".join(names) or "nothing in braces"
