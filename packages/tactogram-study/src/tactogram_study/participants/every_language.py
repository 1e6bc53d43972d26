"""Texts of participants' pages in every language, for pages that cannot know the reader's."""

from __future__ import annotations

import html
from collections.abc import Iterable

from tactogram_study.wording import complete_texts, language_texts


def paragraphs(key: str, languages: Iterable[str] | None = None) -> str:
    """Return a text as HTML, one paragraph for each language; by default in all."""
    return "".join(
        f"<p class='lead' lang='{language}'>{html.escape(complete_texts(language)[key])}</p>\n"
        for language in (language_texts() if languages is None else languages)
    )
