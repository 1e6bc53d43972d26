"""Texts in any number of languages, and language files.

A language file ``nl.toml`` holds the texts of participants' pages and of designs by key, the keys of
``languages/en.toml``. Those of the package are extended by the files and folders of ``TACTOGRAM_LANGUAGES``, key by
key. A missing text is that of English.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    RootModel,
    SerializationInfo,
    field_validator,
    model_serializer,
    model_validator,
)

from tactogram.errors import ParameterError, shown
from tactogram.plugins import further_folders
from tactogram.text_files import read_toml

TAG = r"^[a-z]{2,3}(-[A-Za-z0-9]{2,8}){0,3}$"
Language = Annotated[str, Field(pattern=TAG)]
"""Language tag of BCP 47: ``de``, ``pt-BR``."""
ALL = "*"
"""Key of a text that stands for every language without one of its own."""


class Wording(RootModel[dict[str, str]]):
    """A text by language; a plain string stands for all languages.

    ``Wording("A")``, ``Wording(en="rough", de="rau")`` and ``Wording({"en": "rough", "pt-BR": "áspero"})``. A text of
    ``de`` stands for ``de-AT``, too.
    """

    model_config = ConfigDict(frozen=True)

    root: dict[str, str] = Field(default_factory=dict)

    if TYPE_CHECKING:  # pydantic takes these, and type checkers the field alone

        def __init__(self, texts: Mapping[str, str] | str = ..., /, **by_language: str) -> None:
            """Make a text of what `Wording` shows."""

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {ALL: value} if isinstance(value, str) else value

    @field_validator("root")
    @classmethod
    def _tagged(cls, texts: dict[str, str]) -> dict[str, str]:
        for language in texts:
            if language != ALL and not re.fullmatch(TAG, language):
                raise ValueError(f"a text's language must be a tag such as en, de or pt-BR, got {language!r}")
        return {language: text for language, text in texts.items() if text}

    @model_serializer(mode="plain")
    def _serialised(self, info: SerializationInfo) -> dict[str, str]:
        """Return the texts; those of the ``languages`` of the context, if it names any."""
        languages = (info.context or {}).get("languages")
        return self.texts if languages is None else {tag: self.in_language(tag) for tag in languages}

    @property
    def texts(self) -> dict[str, str]:
        """Texts by language; that of a plain string has the key ``*``."""
        return dict(self.root)

    @property
    def languages(self) -> tuple[str, ...]:
        """Languages with a text of their own, in the order given."""
        return tuple(language for language in self.root if language != ALL)

    def in_language(self, language: str) -> str:
        """Return the text, or "" if there is none."""
        primary = language.partition("-")[0]
        return next((self.root[key] for key in (language, primary, ALL) if key in self.root), "")

    def in_english(self) -> str:
        """Return the text in English, otherwise in its first language, or ""."""
        return self.in_language("en") or next(iter(self.root.values()), "")

    def __bool__(self) -> bool:
        return bool(self.root)

    def filled(self, **values: str | Wording) -> Wording:
        """Return the text with each ``{name}`` replaced by its value in the same language."""
        fillings = {name: Wording.model_validate(value) for name, value in values.items()}
        keys = dict.fromkeys(key for wording in (self, *fillings.values()) for key in wording.root)
        return Wording({key: _filled(self.in_language(key), key, fillings) for key in keys})


def _filled(text: str, language: str, fillings: Mapping[str, Wording]) -> str:
    for name, value in fillings.items():
        text = text.replace(f"{{{name}}}", value.in_language(language))
    return text


def wordings(value: Any, place: Place = (), *, stated: bool = False) -> Iterator[tuple[Place, Wording]]:
    """Yield every text within a model or a tuple of models, with its place; only ``stated`` ones, without defaults."""
    if isinstance(value, Wording):
        yield place, value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            if not stated or name in value.model_fields_set:
                yield from wordings(getattr(value, name), (*place, name), stated=stated)
    elif isinstance(value, tuple):
        for number, inner in enumerate(value):
            yield from wordings(inner, (*place, number), stated=stated)
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from wordings(inner, (*place, name), stated=stated)


FOLDERS_VARIABLE = "TACTOGRAM_LANGUAGES"
"""Environment variable with files and folders of further language files, separated as in PATH."""
ENGLISH = "en"
Texts = Mapping[str, str]
Place = tuple[int | str, ...]


def language_texts() -> Mapping[str, Texts]:
    """Return the texts of each language by key, without those that are missing.

    Raises `ParameterError` if a file is not named after a language, or has a text that no page shows or that is not
    filled in like the English one; `DataError` if it cannot be read.
    """
    own = (path.resolve() for source in further_folders(FOLDERS_VARIABLE) for path in _files(source))
    return _texts(tuple((path, path.stat().st_mtime_ns, path.stat().st_size) for path in own))


def default_text(key: str) -> Wording:
    """Return a text in every language; English stands for those without it."""
    files = language_texts()
    known = {language: texts[key] for language, texts in files.items() if key in texts}
    return Wording(known | {ALL: files[ENGLISH][key]})


def text_field(key: str, title: str | None = None) -> Any:
    """Return a model's field that is by default the text of a key; ``title`` is its label in forms."""
    return Field(default_factory=lambda: default_text(key), title=title)


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
    package = Path(__file__).parent / "languages"
    english = read_toml(package / "en.toml")
    texts: dict[str, dict[str, str]] = {}
    for path in (*_files(package), *(path for path, _, _ in own)):
        texts.setdefault(path.stem, {}).update(_checked(read_toml(path), english, path))
    return texts


def _files(source: Path) -> list[Path]:
    paths = [source] if source.is_file() else sorted(source.glob("*.toml"))
    if not paths:
        raise ParameterError(
            f"{source}: must be a language file such as nl.toml or a folder of such files, found none"
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


def paragraphs(key: str, languages: Iterable[str] | None = None) -> str:
    """Return a text as HTML, a paragraph per language, by default of all: for pages that cannot know the reader's."""
    return "".join(
        f"<p class='lead' lang='{language}'>{html.escape(complete_texts(language)[key])}</p>\n"
        for language in (language_texts() if languages is None else languages)
    )
