"""Texts in the study's languages."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, model_validator

Language = Literal["ja", "en"]
LANGUAGES: tuple[Language, ...] = ("ja", "en")


class Wording(BaseModel):
    """A text in each language; a plain string stands for all of them."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    ja: str = ""
    en: str = ""

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {"ja": value, "en": value} if isinstance(value, str) else value

    def in_language(self, language: Language) -> str:
        """Return the text, or "" if there is none."""
        return self.ja if language == "ja" else self.en

    def __bool__(self) -> bool:
        return bool(self.ja or self.en)

    def filled(self, **values: str | Wording) -> Wording:
        """Return the text with each ``{name}`` replaced by its value in the same language."""
        ja, en = self.ja, self.en
        for name, value in values.items():
            text = Wording.model_validate(value)
            ja, en = ja.replace(f"{{{name}}}", text.ja), en.replace(f"{{{name}}}", text.en)
        return Wording(ja=ja, en=en)


def wordings(value: Any, place: str = "") -> Iterator[tuple[str, Wording]]:
    """Yield every text within a model or a tuple of models, with its place."""
    if isinstance(value, Wording):
        yield place, value
    elif isinstance(value, BaseModel):
        for name in type(value).model_fields:
            yield from wordings(getattr(value, name), f"{place}.{name}" if place else name)
    elif isinstance(value, tuple):
        for number, inner in enumerate(value):
            yield from wordings(inner, f"{place}.{number}")
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from wordings(inner, f"{place}.{name}")
