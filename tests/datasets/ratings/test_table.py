"""What tables of ratings may look like, and what is said of those that may not."""

from pathlib import Path

import numpy as np
import openpyxl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from tactogram.datasets import EVOKED, SEVEN_POINT, Ratings, Scale
from tactogram.datasets.ratings.ratings import scale_of
from tactogram.datasets.ratings.table import RatingColumns, read_table, write_table
from tactogram.datasets.ratings.words import JAPANESE, WORDS
from tactogram.errors import DataError, ParameterError

ROOT = Path(__file__).parents[3]
LONG = "rater,item,word,score\nr1,plate01,rough,6\nr1,plate01,sleek,2\nr2,plate01,rough,4\n"
WIDE = "rater,item," + ",".join(WORDS) + "\nr1,plate01,1,2,3,4,5,6,7,1,2,3\nr2,plate01,7,6,5,4,3,2,1,7,6,5\n"


NAMES = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=6).filter(
    lambda name: name == name.strip()
)


def write(path, text, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))
    return path


class TestReading:
    def test_long(self, tmp_path):
        ratings = read_table(write(tmp_path / "r.csv", LONG)).ratings
        assert (ratings.rater, ratings.word) == (("r1", "r1", "r2"), ("rough", "sleek", "rough"))
        assert ratings.words == ("sleek", "rough")
        assert ratings.scale == SEVEN_POINT

    def test_wide(self, tmp_path):
        ratings = read_table(write(tmp_path / "r.csv", WIDE)).ratings
        assert ratings.words == WORDS
        np.testing.assert_array_equal(
            ratings.cube, [[[1, 2, 3, 4, 5, 6, 7, 1, 2, 3], [7, 6, 5, 4, 3, 2, 1, 7, 6, 5]]]
        )

    @settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(st.permutations(range(12)))
    def test_columns_may_stand_in_any_order(self, tmp_path, order):
        rows = [line.split(",") for line in WIDE.splitlines()]
        text = "\n".join(",".join(row[place] for place in order) for row in rows)
        found = read_table(write(tmp_path / "r.csv", text)).ratings
        assert found.sha256 == read_table(write(tmp_path / "s.csv", WIDE)).ratings.sha256

    @pytest.mark.parametrize(("suffix", "divider"), [(".tsv", "\t"), (".csv", ";"), (".csv", "\t")])
    def test_other_dividers_are_seen(self, tmp_path, suffix, divider):
        found = read_table(write(tmp_path / f"r{suffix}", LONG.replace(",", divider))).ratings
        assert found.sha256 == read_table(write(tmp_path / "s.csv", LONG)).ratings.sha256

    @pytest.mark.parametrize("encoding", ["cp932", ""])
    def test_japanese_excel_is_read(self, tmp_path, encoding):
        text = WIDE.replace(",".join(WORDS), ",".join(JAPANESE.values())).replace(
            "rater,item", "被験者,試料番号"
        )
        path = write(tmp_path / "r.csv", text.replace("plate01", "1"), "cp932")
        named = {"rater": "被験者", "item": "試料番号"}
        columns = RatingColumns(named=named, item="plate{:0>2}", encoding=encoding)
        found = read_table(path, columns=columns)
        assert found.ratings.sha256 == read_table(write(tmp_path / "s.csv", WIDE)).ratings.sha256
        assert found.notes == (() if encoding else ("text read as cp932, not UTF-8",))

    def test_columns_are_mapped_and_ignored(self, tmp_path):
        text = "Subject,Age,Sample,Adjective,Value,Trial\nr1,22,p,Rough (Zarazara-suru),6,3\n"
        named = {
            "rater": "Subject",
            "item": "Sample",
            "word": "Adjective",
            "score": "Value",
            "order": "Trial",
        }
        found = read_table(
            write(tmp_path / "r.csv", text), columns=RatingColumns(named=named, ignored=("Age",))
        ).ratings
        assert (found.rater, found.item, found.word) == (("r1",), ("p",), ("rough",))
        np.testing.assert_array_equal(found.order, [3])

    def test_other_words_and_scales_may_be_asked(self, tmp_path):
        text = "rater,item,energy,tempo\nmean,v1,-2.5,0.25\n"
        found = read_table(
            write(tmp_path / "r.csv", text),
            scale=Scale("x", -3, 3),
            columns=RatingColumns(words=("energy", "tempo")),
        ).ratings
        np.testing.assert_array_equal(found.means, [[-2.5, 0.25]])

    def test_empty_cells_are_missing_and_counted_by_rater(self, tmp_path):
        text = WIDE.replace("r1,plate01,1,2,3", "r1,plate01,,NA,-").replace("r2,plate01,7", "r2,plate01, ")
        found = read_table(write(tmp_path / "r.csv", text + "\n\n"))
        assert found.blank == {"r1": 3, "r2": 1}
        assert len(found.ratings) == 16
        assert np.isnan(found.ratings.cube).sum() == 4
        long = read_table(write(tmp_path / "l.csv", LONG + "r2,plate01,sleek,\n"))
        assert (len(long.ratings), long.blank) == (3, {"r2": 1})

    def test_one_rater_may_meet_an_item_in_two_sessions(self, tmp_path):
        text = "rater,item,word,score,session\nr1,p,rough,6,mon\nr1,p,rough,2,tue\n"
        assert read_table(write(tmp_path / "r.csv", text)).ratings.means[0, 0] == 4

    def test_parquet_of_anybody(self, tmp_path):
        table = pa.table(
            {"item": [1, 1], "score": [1.0, None], "word": ["rough", "dry"], "rater": [7.0, 7.0]}
        )
        pq.write_table(table, tmp_path / "r.parquet")
        found = read_table(tmp_path / "r.parquet", scale=EVOKED, columns=RatingColumns(item="image{:0>3}"))
        assert (found.ratings.rater, found.ratings.item, found.blank) == (("7",), ("image001",), {"7": 1})

    def test_truth_is_a_score_where_a_word_was_evoked_or_not(self, tmp_path):
        rows = {"item": ["p", "q"], "score": [True, False], "word": ["dry", "dry"], "rater": ["r", "r"]}
        pq.write_table(pa.table(rows), tmp_path / "r.parquet")
        assert read_table(tmp_path / "r.parquet", scale=EVOKED).ratings.score.tolist() == [1, 0]
        with pytest.raises(DataError, match="score must be a number, got 'true'"):
            read_table(tmp_path / "r.parquet")

    @pytest.mark.parametrize("name", ["r.csv", "r.tsv", "r.parquet"])
    @pytest.mark.parametrize("form", ["long", "wide"])
    def test_what_is_written_is_read(self, tmp_path, name, form):
        ratings = Ratings(
            ("r1", "r1", "r,2"),
            ("p 1", "p 1", "p 1"),
            ("rough", "dry", "rough"),
            np.array([6.0, 2.0, 4.0]),
            order=np.array([1, 1, -1]),
            session=("a", "a", ""),
            words=WORDS,
        )
        write_table(tmp_path / name, ratings, form=form)
        back = read_table(tmp_path / name, columns=RatingColumns(words=WORDS)).ratings
        assert back.sha256 == ratings.sha256
        assert [path.name for path in tmp_path.iterdir()] == [name]

    @settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
    @given(
        rows=st.dictionaries(
            st.tuples(NAMES, NAMES, st.sampled_from(WORDS)), st.integers(1, 7), min_size=1, max_size=20
        ),
        form=st.sampled_from(["long", "wide"]),
        suffix=st.sampled_from([".csv", ".tsv"]),
    )
    def test_any_names_come_back(self, tmp_path, rows, form, suffix):
        rater, item, word = zip(*rows, strict=True)
        ratings = Ratings(rater, item, word, np.array(list(rows.values()), float), words=WORDS)
        write_table(tmp_path / f"r{suffix}", ratings, form=form)
        back = read_table(tmp_path / f"r{suffix}", columns=RatingColumns(words=WORDS)).ratings
        assert back.sha256 == ratings.sha256

    def test_means_keep_every_digit(self, tmp_path):
        scale = Scale("means", 1, 7)
        ratings = Ratings(("mean",), ("p",), ("rough",), np.array([10 / 3]), scale)
        write_table(tmp_path / "r.csv", ratings, form="wide")
        back = read_table(tmp_path / "r.csv", scale=scale, columns=RatingColumns(words=("rough",)))
        assert back.ratings.sha256 == ratings.sha256


BROKEN = {
    "a score off the scale": (
        LONG + "r3,p,rough,8\n",
        r"row 5 \(r3, p, rough\): score must be 1 to 7 in steps of 1, got 8",
    ),
    "a score between the points": (LONG + "r3,p,rough,2.5\n", "row 5 .*in steps of 1, got 2.5"),
    "an unknown word": (LONG + "r3,p,ruff,2\n", "row 5: word must be one of dry, .*, got 'ruff'"),
    "a rating twice": (
        LONG + "r1,plate01,Rough,5\n",
        r"row 5 \(r1, plate01, rough\): row 2 is the same rating; leave one out, or",
    ),
    "a score that is no number": (
        LONG + "r3,p,rough,much\n",
        r"row 5 \(r3, p, rough\): score must be a number, got 'much'",
    ),
    "an infinite score": (LONG + "r3,p,rough,inf\n", "row 5 .*must be a finite number, got 'inf'"),
    "a row without an item": (LONG + "r3,,rough,2\n", "row 5: item must not be empty"),
    "a row without a rater": (LONG + ",p,rough,2\n", "row 5: rater must not be empty"),
    "a row that is too short": (LONG + "r3,p,rough\n", "row 5: must have 4 cells, got 3"),
    "a row that is too long": (LONG + "r3,p,rough,1,2\n", "row 5: must have 4 cells, got 5"),
    "an order that is none": (
        "rater,item,word,score,order\nr,p,dry,1,0\n",
        "row 2: order must be a whole number from 1, got '0'",
    ),
    "no column of raters": (
        LONG.replace("rater", "age"),
        "column 1 'age' is neither a word nor one of rater, item.*ignore=HEADING",
    ),
    "no column of scores": (
        "rater,item,word\nr,p,dry\n",
        "lacks the column score, has rater, item, word; column",
    ),
    "no column of a word": (
        WIDE.replace("sticky", "session"),
        "lacks the column sticky, has rater.*words=A,B",
    ),
    "a column twice": (WIDE.replace("sticky", "さらさらする"), "columns 3 and 11 both are 'dry'"),
    "both forms at once": (
        "rater,item,word,score,dry\nr,p,dry,1,1\n",
        "columns word and score, or a column per word, got both",
    ),
    "only headings": ("rater,item,word,score\n", "holds no row below its headings"),
    "only empty cells": ("rater,item,word,score\nr,p,dry,\n", r"holds no score in any of its rows \(1\)"),
    "nothing": ("", "must begin with a row of headings, got none"),
    "an open quote": (LONG + '"r3,p,rough,1\n', "not a table: unexpected end of data"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_table_is_refused_with_its_row(tmp_path, name):
    text, says = BROKEN[name]
    with pytest.raises(DataError, match=says) as caught:
        read_table(write(tmp_path / "r.csv", text))
    assert "\n" not in str(caught.value)
    said = str(caught.value).removeprefix(f"{tmp_path / 'r.csv'}: ")
    assert f"- {name}: `{said}`\n" in (ROOT / "docs/rating-tables.md").read_text(encoding="utf-8")


def test_files_that_are_no_tables_are_refused(tmp_path):
    with pytest.raises(DataError, match=r"must be .csv, .tsv, .parquet, .xlsx, .json, got '.ods'"):
        read_table(tmp_path / "r.ods")
    with pytest.raises(DataError, match="r.xlsx: no such file"):
        read_table(tmp_path / "r.xlsx")
    with pytest.raises(DataError, match="r.json: must hold a list of objects, one per row"):
        read_table(write(tmp_path / "r.json", '{"rater": "r"}'))
    with pytest.raises(DataError, match="r.csv: no such file"):
        read_table(tmp_path / "r.csv")
    with pytest.raises(DataError, match="r.parquet: not a readable Parquet file"):
        read_table(write(tmp_path / "r.parquet", LONG))
    with pytest.raises(DataError, match="has no column 'Value', but rater"):
        read_table(
            write(tmp_path / "r.csv", LONG),
            columns=RatingColumns(named={"score": "Value"}, ignored=("score",)),
        )


def test_a_workbook_whose_last_cell_is_filled_does_not_take_all_memory(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["rater", "item", "word", "score"])
    book.active.cell(1_048_576, 16_384, 3)
    book.save(tmp_path / "r.xlsx")
    with pytest.raises(DataError, match="r.xlsx: a sheet must have at most 33554432 cells up to its last"):
        read_table(tmp_path / "r.xlsx")


def test_a_scale_has_a_name_or_two_ends():
    assert scale_of("evoked") == EVOKED
    assert scale_of("7-point") == scale_of("7-point unipolar") == SEVEN_POINT
    assert scale_of("-3:3") == Scale("-3:3", -3, 3)
    assert scale_of("0:100:5") == Scale("0:100:5", 0, 100, 5)
    for text in ("seven", "1", "1:7:1:2", "7:1", "1:7:0"):
        with pytest.raises(ParameterError, match="scale"):
            scale_of(text)


def test_writing_refuses_another_suffix(tmp_path):
    ratings = Ratings(("r",), ("p",), ("rough",), np.array([1.0]))
    with pytest.raises(ParameterError, match="got r.xlsx long"):
        write_table(tmp_path / "r.xlsx", ratings)
    assert list(tmp_path.iterdir()) == []
