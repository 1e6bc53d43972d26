"""The ten words in both languages."""

import pytest

from tactogram.datasets.ratings.words import JAPANESE, ROMAJI, WORDS, word_of

PRINTED = (
    "Dry (Sarasara-suru)", "Sleek (Subesube-suru)", "Slippery (Tsurutsuru-suru)", "Rugged (Gotsugotsu-suru)",
    "Uneven (Bokoboko-suru)", "Rough (Zarazara-suru)", "Squishy (Gunyagunya-suru)", "Prickle (Chikuchiku-suru)",
    "Sticky (Petapeta-suru)", "Rustle (Gasagasa-suru)",
)  # fmt: skip
"""Hatori & Takemura 2023, Table 1, row by row."""


class TestWords:
    def test_words_are_those_of_table_1_in_its_order(self):
        assert [word_of(text) for text in PRINTED] == list(WORDS)

    @pytest.mark.parametrize("word", WORDS)
    def test_a_heading_may_be_of_any_of_the_languages(self, word):
        printed = f"{word.title()} ({ROMAJI[word].title()})"
        forms = [
            word,
            word.upper(),
            f" {word} ",
            JAPANESE[word],
            JAPANESE[word].removesuffix("する"),
            printed,
        ]
        forms += [ROMAJI[word], ROMAJI[word].replace("-", " "), ROMAJI[word].removesuffix("-suru")]
        assert {word_of(form) for form in forms} == {word}

    @pytest.mark.parametrize("text", ["", "roughness", "Dry (Zarazara-suru)", "する", "suru", "ざら"])
    def test_what_is_none_of_them_is_none(self, text):
        assert word_of(text) is None
