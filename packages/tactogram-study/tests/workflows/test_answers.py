import random
import re

import pytest

from tactogram.cli import main
from tactogram.errors import DataError, TactogramError
from tactogram_study.answers import read_answers
from tactogram_study.session.store import SessionStore
from tactogram_study.workflows.analysis import analyse_study
from tactogram_study.workflows.answers import export_study, salvage_session
from tactogram_study.workflows.sessions import end_session, session_progress

PAGE = 4096


def flipped_page(data, number):
    start = (number - 1) * PAGE
    return data[:start] + bytes(255 - byte for byte in data[start : start + PAGE]) + data[start + PAGE :]


def leaves(folder):
    """Return the numbers of the pages with answers."""
    data = (folder / "answers.sqlite").read_bytes()
    pages = [data[start : start + PAGE] for start in range(0, len(data), PAGE)]
    return [number for number, page in enumerate(pages, 1) if page[0] == 0x0D and b'{"study": ' in page]


def opened(folder, tmp_path):
    """Call what opens a session folder, and return the errors."""
    errors = []
    for open_session in (
        lambda: export_study(folder, out=tmp_path / "a.csv"),
        lambda: analyse_study(folder, tmp_path / "found", figures=False, draws=100),
        lambda: session_progress(folder),
        lambda: end_session(folder),
    ):
        try:
            open_session()
        except TactogramError as error:
            errors.append(error)
    return errors


def test_an_undamaged_session_is_salvaged_completely(whole):
    folder, answers = whole
    found = salvage_session(folder)
    assert (sorted(map(repr, found.answers)), found.lost) == (sorted(map(repr, answers)), 0)
    with SessionStore(folder) as store:
        assert found.study == store.study


def test_a_damaged_page_loses_its_rows_alone(whole, damaged):
    folder, answers = whole
    middle = leaves(folder)[len(leaves(folder)) // 2]
    found = salvage_session(damaged(lambda data: flipped_page(data, middle)))
    assert 0 < found.lost < 10
    assert len(found.answers) == len(answers) - found.lost
    assert set(map(repr, found.answers)) < set(map(repr, answers))


@pytest.mark.parametrize("share", [0.6, 0.95])
def test_a_truncated_file_keeps_the_rows_before_the_cut(whole, damaged, share):
    folder, answers = whole
    cut = int(share * (folder / "answers.sqlite").stat().st_size)
    found = salvage_session(damaged(lambda data: data[:cut]))
    kept = sum(number * PAGE <= cut for number in leaves(folder)) / len(leaves(folder))
    assert len(found.answers) / len(answers) == pytest.approx(kept, abs=0.1)
    assert set(map(repr, found.answers)) < set(map(repr, answers))


def test_a_row_with_broken_json_is_lost_alone(whole, damaged):
    folder = damaged(statements=["UPDATE answers SET row = substr(row, 1, 90) WHERE rowid IN (3, 70)"])
    found = salvage_session(folder)
    assert (len(found.answers), found.lost) == (len(whole[1]) - 2, 2)


DAMAGE = {
    "header": ((lambda data: b"\0" * 100 + data[100:]), ()),
    "truncated": ((lambda data: data[: len(data) // 2]), ()),
    "names": ((lambda data: data.replace(b"pagespages\x05CREATE", b"p\x83gespages\x05CREATX")), ()),
    "study": (None, ["UPDATE study SET facts = '{\"name\": '"]),
    "no study": (None, ["DELETE FROM study"]),
    "row": (None, ["UPDATE answers SET row = '[1]' WHERE rowid = 9"]),
    "key": (None, ["UPDATE answers SET row = replace(row, 'rt_ms', 'rt_xx')"]),
    "responses": (None, ["UPDATE pages SET responses = '{' WHERE position = 4"]),
    "no answers": (None, ["PRAGMA foreign_keys=OFF", "DROP TABLE answers"]),
    "no pages": (None, ["PRAGMA foreign_keys=OFF", "DROP TABLE pages"]),
    "no participants": (None, ["PRAGMA foreign_keys=OFF", "DROP TABLE participants"]),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_session_is_reported_in_a_line_that_names_it(damaged, tmp_path, kind):
    change, statements = DAMAGE[kind]
    errors = opened(damaged(change, statements=statements), tmp_path)
    assert errors
    for error in map(str, errors):
        assert re.search(
            r"pilot: answers\.sqlite is damaged \(.+\); .* study export \S+ --salvage --out", error
        )


@pytest.mark.parametrize("seed", range(6))
def test_flipped_bytes_raise_nothing_but_one_line(damaged, tmp_path, seed):
    rng = random.Random(seed)

    def flip(data):
        flipped = bytearray(data)
        for _ in range(40):
            flipped[rng.randrange(100, len(data))] ^= 1 << rng.randrange(8)
        return bytes(flipped)

    folder = damaged(flip)
    for error in opened(folder, tmp_path):
        assert isinstance(error, DataError)
    assert len(salvage_session(folder).answers) > 0


def test_the_command_exports_what_can_be_read_and_reports_what_is_lost(whole, damaged, tmp_path, capsys):
    folder = damaged(statements=["UPDATE answers SET row = '{' WHERE rowid = 5"])
    assert main(["study", "export", str(folder), "--out", str(tmp_path / "a.csv")]) == 1
    message = capsys.readouterr().err
    assert f"tactogram study export {folder} --salvage --out F.csv" in message
    assert not (tmp_path / "a.csv").exists()
    assert main(["study", "export", str(folder), "--salvage", "--out", str(tmp_path / "a.csv")]) == 0
    assert "note: at least 1 rows of answers are lost" in capsys.readouterr().err
    assert len(read_answers(tmp_path / "a.csv")) == len(whole[1]) - 1
    assert (tmp_path / "a.study.json").is_file()
