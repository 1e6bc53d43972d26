"""Texts in any number of languages."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
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
        return self.texts if languages is None else {one: self.in_language(one) for one in languages}

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


def wordings(value: Any, place: str = "", *, stated: bool = False) -> Iterator[tuple[str, Wording]]:
    """Yield every text within a model or a tuple of models, with its place; only ``stated`` ones, without defaults."""
    if isinstance(value, Wording):
        yield place, value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            if not stated or name in value.model_fields_set:
                yield from wordings(getattr(value, name), f"{place}.{name}" if place else name, stated=stated)
    elif isinstance(value, tuple):
        for number, inner in enumerate(value):
            yield from wordings(inner, f"{place}.{number}", stated=stated)
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from wordings(inner, f"{place}.{name}", stated=stated)
