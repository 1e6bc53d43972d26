"""Exports of PsychoPy, jsPsych, Qualtrics and Google Forms as they are: right, asked or refused, and said."""

import csv
import io
import json

import openpyxl
import pytest

from tactogram.datasets import SEVEN_POINT, Scale
from tactogram.datasets.ratings.questions import RatingColumns
from tactogram.datasets.ratings.table import read_table
from tactogram.errors import DataError


def test_other_tables_leave_out_unnamed_columns_and_empty_rows(tmp_path):
    rows = [
        ["", "rater", "item", "word", "score", "Age"],
        ["0", "r", "tile", "dry", "3", "9"],
        ["1", "r", "", "", "", "9"],
    ]
    path = write(tmp_path / "r.csv", rows)
    with pytest.raises(DataError, match=r"column 6 'Age' is neither.*ignore=HEADING \(or \*\)"):
        read(path)
    table = read(path, ignored=("*",))
    assert scores(table) == {("r", "tile", "dry"): 3}
    assert table.notes == (
        "columns left out, as they have no heading: 1",
        "columns left out: Age",
        "rows left out without item and score: 1, the first is row 3",
    )


ITEMS = ("tile", "carpet", "cork board", "cork")


def write(path, rows, *, divider=",", encoding="utf-8"):
    text = io.StringIO()
    csv.writer(text, delimiter=divider).writerows(rows)
    path.write_bytes(text.getvalue().encode(encoding))
    return path


def read(path, *, scale=SEVEN_POINT, **columns):
    return read_table(path, scale=scale, columns=RatingColumns(**columns), items=ITEMS)


def scores(table):
    """Return the scores by rater, item and word."""
    found = table.ratings
    keys = zip(found.rater, found.item, found.word, strict=True)
    return dict(zip(keys, found.score.tolist(), strict=True))


PSYCHOPY_TAIL = ["p01", "001", "2026-01-02_10h23.45.123", "texture", "2024.2.4", "60.0", ""]


def psychopy(*headings):
    """Return a row of headings with those that PsychoPy adds, the last of which is empty."""
    added = ["participant", "session", "date", "expName", "psychopyVersion", "frameRate", ""]
    return [*headings, "trials.thisN", *added]


class TestPsychoPy:
    ROWS = (
        psychopy(
            "material", "instr.started", "rough_slider.response", "rough_slider.rt", "stickySlider.response"
        ),
        ["", "0.3", "", "", "", "", *PSYCHOPY_TAIL],
        ["tile", "", "1", "2.1", "4", "0", *PSYCHOPY_TAIL],
        ["Cork", "", "7", "3.0", "None", "1", *PSYCHOPY_TAIL],
    )

    def test_sliders_are_the_words_and_bookkeeping_is_left_out(self, tmp_path):
        table = read(write(tmp_path / "p.csv", self.ROWS))
        rows = {("tile", "rough"): 1, ("tile", "sticky"): 4, ("cork", "rough"): 7}
        assert scores(table) == {("p01", *key): value for key, value in rows.items()}
        assert table.ratings.session == ("001",) * 3
        assert table.blank == {"p01": 1}
        assert table.notes == (
            "read as an export of PsychoPy: rater of 'participant', item of 'material'",
            "columns left out, as they have no heading: 13",
            "rows left out without an answer: 1, the first is row 2",
            "columns left out: rough_slider.rt, trials.thisN, date, expName, psychopyVersion, frameRate",
        )

    def test_a_word_per_row_and_files_as_items(self, tmp_path):
        rows = [
            psychopy("sound", "adjective", "slider.response", "slider.rt"),
            ["sounds/tile.wav", "rough", "6", "1.2", "0", *PSYCHOPY_TAIL],
            ["sounds/cork board.wav", "sticky", "2", "1.2", "1", *PSYCHOPY_TAIL],
        ]
        table = read(write(tmp_path / "p.csv", rows, divider=";", encoding="utf-8-sig"))
        assert scores(table) == {("p01", "tile", "rough"): 6, ("p01", "cork board", "sticky"): 2}

    def test_a_slider_without_a_word_is_asked_about(self, tmp_path):
        rows = [psychopy("material", "slider.response"), ["tile", "6", "0", *PSYCHOPY_TAIL]]
        path = write(tmp_path / "p.csv", rows)
        with pytest.raises(
            DataError, match=r"which item and word are the numbers in 'slider.response'\?.*column.WORD"
        ):
            read(path)
        assert scores(read(path, named={"rough": "slider.response"})) == {("p01", "tile", "rough"): 6}

    def test_a_practice_slider_is_not_counted_silently(self, tmp_path):
        rows = [
            psychopy("material", "practice_rough.response", "rough.response"),
            ["tile", "1", "", "", *PSYCHOPY_TAIL],
            ["tile", "", "6", "0", *PSYCHOPY_TAIL],
        ]
        path = write(tmp_path / "p.csv", rows)
        with pytest.raises(
            DataError, match=r"in 'practice_rough.response', 'rough.response'\?.*ignore=HEADING"
        ):
            read(path)
        table = read(path, ignored=("practice_rough.response",))
        assert scores(table) == {("p01", "tile", "rough"): 6}

    def test_items_of_a_practice_are_left_out_by_name(self, tmp_path):
        rows = [
            psychopy("material", "rough.response"),
            ["foam", "1", "", *PSYCHOPY_TAIL],
            ["tile", "6", "0", *PSYCHOPY_TAIL],
        ]
        table = read(write(tmp_path / "p.csv", rows), without=("foam",))
        assert scores(table) == {("p01", "tile", "rough"): 6}
        assert "rows left out of foam: 1, the first is row 2" in table.notes

    def test_repeats_are_told_apart_by_a_column(self, tmp_path):
        rows = [
            psychopy("material", "rough.response", "trials.thisRepN"),
            ["tile", "6", "0", "0", *PSYCHOPY_TAIL],
            ["tile", "5", "1", "1", *PSYCHOPY_TAIL],
        ]
        path = write(tmp_path / "p.csv", rows)
        with pytest.raises(DataError, match=r"row 3 .*row 2 is the same rating; .*column.session=HEADING"):
            read(path)
        assert read(path, named={"session": "trials.thisRepN"}).ratings.session == ("0", "1")

    def test_two_columns_of_items_are_asked_about(self, tmp_path):
        rows = [psychopy("left", "right", "rough.response"), ["tile", "cork", "6", "0", *PSYCHOPY_TAIL]]
        path = write(tmp_path / "p.csv", rows)
        with pytest.raises(DataError, match=r"column.item=HEADING"):
            read(path)
        assert scores(read(path, named={"item": "right"})) == {("p01", "cork", "rough"): 6}


JSPSYCH = ["rt", "response", "trial_type", "trial_index", "time_elapsed", "stimulus", "subject"]


class TestJsPsych:
    def likert(self, path, *answers, person="s1"):
        trials = [
            ["5120", "null", "html-keyboard-response", "0", "5121", "<p>Welcome</p>", person],
            *(
                ["3120", json.dumps(answer), "survey-likert", str(n), str(9000 + n), f"<b>{item}</b>", person]
                for n, (item, answer) in enumerate(answers, 1)
            ),
        ]
        return write(path, [JSPSYCH, *trials])

    def test_likert_positions_from_0_become_points_of_the_scale(self, tmp_path):
        path = self.likert(tmp_path / "j.csv", ("tile", {"rough": 6, "sticky": 5}), ("cork", {"rough": 0}))
        table = read(path)
        assert scores(table) == {
            ("s1", "tile", "rough"): 7,
            ("s1", "tile", "sticky"): 6,
            ("s1", "cork", "rough"): 1,
        }
        assert table.notes[1:3] == (
            "rows left out of other plugins (html-keyboard-response): 1, the first is row 2",
            "scores raised by 1, as survey-likert counts from 0: 3",
        )
        assert "columns left out: rt, trial_type, trial_index, time_elapsed" in table.notes
        assert scores(read(path, scale=Scale("0:6:1", 0, 6, 1)))["s1", "tile", "rough"] == 6

    def test_questions_without_a_name_are_asked_about(self, tmp_path):
        path = self.likert(tmp_path / "j.csv", ("tile", {"Q0": 3, "Q1": 0}))
        with pytest.raises(DataError, match="numbers in 'Q0', 'Q1'"):
            read(path)
        assert scores(read(path, named={"rough": "Q0", "dry": "Q1"})) == {
            ("s1", "tile", "rough"): 4,
            ("s1", "tile", "dry"): 1,
        }

    @pytest.mark.parametrize("kind", ["csv", "json"])
    def test_sliders_with_a_picture_and_a_word_per_trial(self, tmp_path, kind):
        headings = [*JSPSYCH, "word"]
        rows = [
            ["", "", "preload", "0", "9", "", "s1", ""],
            *(
                [
                    "900",
                    answer,
                    "html-slider-response",
                    str(n),
                    "99",
                    f'<img src="img/{item}.png">',
                    "s1",
                    word,
                ]
                for n, (item, word, answer) in enumerate([("tile", "rough", 5), ("cork", "dry", 2)], 1)
            ),
        ]
        path = tmp_path / f"j.{kind}"
        if kind == "csv":
            write(path, [headings, *rows])
        else:
            path.write_text(json.dumps([dict(zip(headings, row, strict=True)) for row in rows]))
        assert scores(read(path)) == {("s1", "tile", "rough"): 5, ("s1", "cork", "dry"): 2}

    def test_answers_about_no_item_are_no_ratings(self, tmp_path):
        path = self.likert(tmp_path / "j.csv", ("tile", {"rough": 3}), ("", {"experience": 2}))
        table = read(path)
        assert scores(table) == {("s1", "tile", "rough"): 4}
        assert "rows left out without an answer: 1, the first is row 4" in table.notes

    def test_a_file_without_a_subject_is_a_person_but_several_are_asked_about(self, tmp_path):
        path = self.likert(tmp_path / "kim.csv", ("tile", {"rough": 1}), person="")
        assert scores(read(path)) == {("kim", "tile", "rough"): 2}
        rows = list(csv.reader(path.read_text().splitlines()))
        with pytest.raises(DataError, match="which column names the people"):
            read(write(path, rows + rows[1:]))

    def test_trials_without_ratings_are_refused(self, tmp_path):
        with pytest.raises(
            DataError, match="no trial asks for ratings, as survey-likert, but html-keyboard-response"
        ):
            read(self.likert(tmp_path / "j.csv"))


META = [
    "StartDate",
    "EndDate",
    "Status",
    "Progress",
    "Finished",
    "ResponseId",
    "RecipientEmail",
    "UserLanguage",
]


ASKED = ["Q1_1", "Q1_2", "Q2_1", "Q2_2", "Q3", "Q4_TEXT"]


TEXTS = [
    *(
        "Start Date",
        "End Date",
        "Response Type",
        "Progress",
        "Finished",
        "Response ID",
        "Recipient Email",
        "Language",
    ),
    *("Touch the tile,\nthen answer. - rough", "Touch the tile,\nthen answer. - sticky"),
    *("Touch the cork board - rough", "Touch the cork board - sticky", "How old are you?", "Comments"),
]


IMPORTED = [json.dumps({"ImportId": name}) for name in (*META, *ASKED)]


def person(code, *answers, status="IP Address", finished="True"):
    day = "2026-01-02 10:00:00"
    return [day, day, status, "100", finished, code, "", "EN", *answers, "23", "nice, 7 of 7"]


class TestQualtrics:
    ROWS = (
        [*META, *ASKED],
        TEXTS,
        IMPORTED,
        person("R_p", "1", "1", "1", "1", status="Survey Preview"),
        person("R_1", "5", "2", "3", "4"),
        person("R_u", "5", "", "", "", finished="False"),
        person("R_2", "6", "1", "", "7"),
    )
    RIGHT = (
        {("R_1", "tile", "rough"): 5, ("R_1", "tile", "sticky"): 2, ("R_1", "cork board", "rough"): 3}
        | {("R_1", "cork board", "sticky"): 4, ("R_2", "tile", "rough"): 6, ("R_2", "tile", "sticky"): 1}
        | {("R_2", "cork board", "sticky"): 7}
    )

    @pytest.mark.parametrize(
        ("suffix", "divider", "encoding"), [("csv", ",", "utf-8-sig"), ("tsv", "\t", "utf-16")]
    )
    def test_items_and_words_are_those_of_the_questions(self, tmp_path, suffix, divider, encoding):
        table = read(write(tmp_path / f"q.{suffix}", self.ROWS, divider=divider, encoding=encoding))
        assert scores(table) == self.RIGHT
        assert table.blank == {"R_2": 1}
        assert table.notes == (
            "read as an export of Qualtrics: rater of 'ResponseId', item of the questions",
            "rows left out of questions and their identifiers: 2, the first is row 2",
            "rows left out of previews: 1, the first is row 4; keep them by `ignore=Status`",
            "rows left out of unfinished answers: 1, the first is row 6; keep them by `ignore=Finished`",
            "columns left out: StartDate, EndDate, Status, Progress, Finished, UserLanguage, Q3, Q4_TEXT",
        )

    def test_numeric_states_mean_the_same(self, tmp_path):
        states = {"Survey Preview": "1", "IP Address": "0", "True": "1", "False": "0"}
        rows = [[states.get(cell, cell) for cell in row] for row in self.ROWS]
        assert scores(read(write(tmp_path / "q.csv", rows))) == self.RIGHT

    def test_unfinished_answers_count_on_request(self, tmp_path):
        table = read(write(tmp_path / "q.csv", self.ROWS), ignored=("Finished",))
        assert scores(table) == self.RIGHT | {("R_u", "tile", "rough"): 5}

    def test_a_workbook_without_identifiers(self, tmp_path):
        book = openpyxl.Workbook()
        for row in (*self.ROWS[:2], *self.ROWS[3:]):
            book.active.append([float(cell) if cell.isdecimal() else cell for cell in row])
        book.save(tmp_path / "q.xlsx")
        assert scores(read(tmp_path / "q.xlsx")) == self.RIGHT
        book.create_sheet("more").append(["a"])
        book.save(tmp_path / "q.xlsx")
        with pytest.raises(
            DataError, match="must have one sheet, got Sheet, more; save that of the answers as CSV"
        ):
            read(tmp_path / "q.xlsx")

    def test_choices_in_words_need_their_order(self, tmp_path):
        rows = [*self.ROWS[:3], person("R_1", "Agree", "Neutral", "Disagree", "Agree")]
        path = write(tmp_path / "q.csv", rows)
        with pytest.raises(
            DataError, match="answers are texts: 'Agree', 'Neutral', 'Disagree'; answers=A,B,"
        ):
            read(path)
        three, order = Scale("1:3:1", 1, 3, 1), ("Disagree", "Neutral", "Agree")
        assert [*scores(read(path, scale=three, answers=order)).values()] == [3, 2, 1, 3]
        with pytest.raises(DataError, match="answers must be one per point of 1 to 7 in steps of 1, got 3"):
            read(path, answers=order)

    def test_a_number_in_a_choice_is_its_score(self, tmp_path):
        rows = [*self.ROWS[:3], person("R_1", "7 - very", "1 = not at all", "(3)", "rather (6)")]
        assert [*scores(read(write(tmp_path / "q.csv", rows))).values()] == [7, 1, 3, 6]

    def test_numbers_of_no_word_are_asked_about(self, tmp_path):
        rows = [
            [*row, extra]
            for row, extra in zip(self.ROWS, ["Q5", "How nice is the tile?", "{}", *"5555"], strict=True)
        ]
        path = write(tmp_path / "q.csv", rows)
        with pytest.raises(DataError, match=r"numbers in 'Q5' \(How nice is the tile\?\)\? .*ignore=HEADING"):
            read(path)
        assert scores(read(path, ignored=("*",))) == self.RIGHT
        assert scores(read(path, words=("rough", "sticky", "nice")))["R_1", "tile", "nice"] == 5


class TestGoogleForms:
    def test_a_grid_per_item(self, tmp_path):
        rows = [
            [
                "Timestamp",
                "Email Address",
                "Score",
                "Tile [Rough]",
                "Tile [Dry]",
                "Cork [Rough]",
                "Age",
                "Comments, 1 line",
            ],
            ["2026/01/02 10:23:45 AM GMT+9", "a@b.c", "0 / 0", "6", "2", "3", "23", "good, thanks"],
            ["2026/01/02 10:25:45 AM GMT+9", "d@e.f", "0 / 0", "5", "1", "", "31", ""],
        ]
        table = read(write(tmp_path / "form.csv", rows))
        found = {("tile", "rough"): (6, 5), ("tile", "dry"): (2, 1), ("cork", "rough"): (3,)}
        people = ("form-1", "form-2")
        assert scores(table) == {
            (rater, *key): value
            for key, own in found.items()
            for rater, value in zip(people, own, strict=False)
        }
        assert table.blank == {"form-2": 1}
        assert table.notes[1:] == (
            "columns left out: Timestamp, Score, Age, Comments, 1 line",
            "e-mail addresses replaced by codes",
        )

    def test_an_item_per_row(self, tmp_path):
        rows = [
            ["Zeitstempel", "Participant number", "Which surface is it?", "How rough is it, from 1 to 7?"],
            ["02.01.2026 10:23:45", "1", "Tile", "6"],
            ["02.01.2026 10:24:45", "1", "Cork", "3"],
        ]
        path = write(tmp_path / "form.csv", rows, divider=";")
        assert scores(read(path)) == {("1", "tile", "rough"): 6, ("1", "cork", "rough"): 3}
        with pytest.raises(DataError, match="which column names the people"):
            read(path, ignored=("Participant number",))
        with pytest.raises(DataError, match="of which item and word"):
            read(path, ignored=("How rough is it", "from 1 to 7?"))

    def test_japanese(self, tmp_path):
        rows = [
            ["タイムスタンプ", "参加者番号", "tile [ざらざらする]", "cork [さらさら]"],
            ["2026/01/02 10:23:45", "1", "6", "2"],
        ]
        table = read(write(tmp_path / "form.csv", rows, encoding="cp932"))
        assert scores(table) == {("1", "tile", "rough"): 6, ("1", "cork", "dry"): 2}
        assert "text read as cp932, not UTF-8" in table.notes

    def test_a_scale_between_two_words_is_asked_about(self, tmp_path):
        question = "Tile: from dry (1) to sticky (7)"
        path = write(tmp_path / "form.csv", [["Timestamp", question], ["1/2/2026 10:23:45", "5"]])
        with pytest.raises(DataError, match="column.WORD=HEADING"):
            read(path)
        assert scores(read(path, named={"sticky": question})) == {("form-2", "tile", "sticky"): 5}

    def test_the_same_question_twice_is_asked_about(self, tmp_path):
        rows = [["Timestamp", "How rough is it?", "How rough is it?"], ["1/2/2026 10:23:45", "1", "6"]]
        with pytest.raises(DataError, match=r"numbers in 'How rough is it\?', 'How rough is it\?'"):
            read(write(tmp_path / "form.csv", rows))
