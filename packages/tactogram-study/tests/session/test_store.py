import contextlib
import shutil
import sqlite3
import subprocess
import sys
import threading
from collections import Counter
from functools import partial
from pathlib import Path

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.session import store as session_store
from tactogram_study.session.participants import CODE, drawn_code
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import SimulatedParticipant, take

HASH = "0" * 64


def answer(store, code, count=1):
    """Answer so many pages as a simulated participant."""
    participant = store.participant(code)
    return take(
        store, participant, SimulatedParticipant(SimulatedEffect(), (0, participant.number)), most_pages=count
    )


def tokens(store):
    return [row.more["token"] for row in store.answers()]


def test_answers_are_there_when_the_file_is_opened_again(store):
    code = store.enrol("P1").code
    answer(store, code, 5)
    shown = store.page(code)
    with SessionStore(store.path.parent) as again:
        assert again.page(code) == shown
        assert again.answers() == store.answers()
        assert tokens(again) == ["consent", "before", "trial-1.1", "trial-2.1", "trial-3.1"]


def test_a_page_that_is_sent_again_is_stored_once_and_the_first_answer_stays(store):
    code = store.enrol().code
    answer(store, code, 2)
    token = store.page(code).token
    first = store.submit(code, token, {"which": "A"}, rt_ms={"": 900})
    again = store.submit(code, token, {"which": "B"})
    assert (first.stored, again.stored) == (True, False)
    assert again.page == first.page
    [row] = store.answers().where(token=token)
    assert (row.answer, row.rt_ms) == ("A", 900)


def test_an_answer_to_a_page_that_is_not_there_yet_is_refused(store):
    code = store.enrol("P1").code
    with pytest.raises(ParameterError, match="P1 is at page consent, got an answer to 'trial-1.1'; reload"):
        store.submit(code, "trial-1.1", {"which": "A"})
    assert len(store.answers()) == 0


@pytest.mark.parametrize(
    ("responses", "message"),
    [
        ({}, "which: must be answered, got nothing"),
        ({"which": "C"}, "which: must be one of A, B, got 'C'"),
        ({"which": "A", "more": "x"}, "page trial-1.1 asks which, got an answer to 'more'"),
    ],
)
def test_what_is_no_answer_stores_nothing(store, responses, message):
    code = store.enrol().code
    answer(store, code, 2)
    with pytest.raises(ParameterError, match=message):
        store.submit(code, "trial-1.1", responses)
    assert tokens(store) == ["consent", "before"]


def test_a_kill_at_any_instant_loses_nothing_that_was_said_to_be_stored(make_study, tmp_path):
    with SessionStore(tmp_path, make_study({"kind": "abx", "repeats": 200})) as store:
        code = store.enrol().code
    script = [sys.executable, str(Path(__file__).with_name("killed_participant.py")), str(tmp_path), code]
    with subprocess.Popen(script, stdout=subprocess.PIPE, text=True) as process:
        said = [process.stdout.readline().strip() for _ in range(5)]
        process.kill()
        said += process.stdout.read().split()
    with SessionStore(tmp_path) as store:
        stored = tokens(store)
        assert set(said) <= set(stored)
        assert len(set(stored)) == len(stored)
        assert 5 <= len(stored) < 203
        answer(store, code, None)
        assert store.page(code) is None
        assert Counter(tokens(store)).most_common(1)[0][1] == 1


def test_a_power_cut_keeps_what_was_stored(store, tmp_path):
    code = store.enrol().code
    answer(store, code, 6)
    kept = tokens(store)
    cut = tmp_path / "cut"
    cut.mkdir()
    # What is on the disk at this instant, without the index in memory and with a torn page at the log's end.
    for name in ("answers.sqlite", "answers.sqlite-wal"):
        shutil.copy(store.path.with_name(name), cut / name)
    with (cut / "answers.sqlite-wal").open("ab") as file:
        file.write(b"\x37" * 2500)
    with SessionStore(cut) as found:
        assert tokens(found) == kept
        assert found.page(code) == store.page(code)


def test_the_file_is_written_through_to_the_disk(store):
    pragmas = {
        name: store._connection.execute(f"PRAGMA {name}").fetchone()[0]
        for name in ("journal_mode", "synchronous")
    }
    assert pragmas == {"journal_mode": "wal", "synchronous": 2}


def test_two_who_write_at_once_lose_nothing_and_store_nothing_twice(make_study, tmp_path):
    with SessionStore(tmp_path, make_study()) as store:
        codes = [store.enrol().code for _ in range(2)]
    failed = []

    def person(code):
        try:
            with SessionStore(tmp_path) as own:
                answer(own, code, None)
        except Exception as error:  # reported below; a thread's own would be lost
            failed.append(error)

    # Each participant in two windows at once.
    threads = [threading.Thread(target=person, args=(code,)) for code in codes * 2]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # The second window of a participant may be told that its page is behind; that is all that may happen.
    assert all(isinstance(error, ParameterError) and "reload the page" in str(error) for error in failed)
    with SessionStore(tmp_path) as store:
        for code in codes:
            answer(store, code, None)
            own = [row.more["token"] for row in store.answers().where(participant=code)]
            assert len(own) == len(set(own)) == 8 + 3


def test_a_full_disk_stores_nothing_and_the_next_answers_are_stored(store):
    code = store.enrol().code
    pages = store._connection.execute("PRAGMA page_count").fetchone()[0]
    store._connection.execute(f"PRAGMA max_page_count = {pages}")
    note = partial(store.note, "x" * 4000)
    with pytest.raises(DataError, match="nothing was stored: database or disk is full"):
        [note() for _ in range(9)]
    kept = store.notes()
    store._connection.execute("PRAGMA max_page_count = 1000000")
    assert store.notes() == kept
    assert store.submit(code, "consent", {"consent": "agreed"}).stored


def test_who_reads_waits_for_nobody_who_writes_and_sees_what_is_on_the_disk(store):
    code = store.enrol().code
    seen = []

    def look():
        seen.append((store.page(code).token, store.count, store.withdrawn))

    with store._writing() as rows:
        rows.execute("UPDATE study SET withdrawn = 1")
        reader = threading.Thread(target=look, daemon=True)
        reader.start()
        reader.join(10)  # while this thread writes
    look()
    assert seen == [("consent", 0, 0), ("consent", 0, 1)]


def test_what_another_process_stores_is_seen_at_once(store):
    code = store.enrol("P1").code
    answer(store, code, 3)
    with SessionStore(store.path.parent) as other:
        answer(other, code, 1)
        assert store.page(code).token == "trial-3.1"
        other.withdraw(code)
        other.enrol("P1")
    assert store.page(code).token == "consent"
    assert store.submit(code, "consent", {"consent": "agreed"}).page.token == "before"


def test_a_clock_that_is_set_back_changes_no_order(store, monkeypatch):
    code = store.enrol().code
    times = iter(f"20{year}-01-01T00:00:00.000+00:00" for year in range(60, 10, -1))
    monkeypatch.setattr(session_store, "now_utc", lambda: next(times))
    answer(store, code, 6)
    assert tokens(store) == ["consent", "before", *(f"trial-{n}.1" for n in range(1, 5))]
    assert store.page(code).trial == 5


def test_the_latest_answers_come_first_whatever_the_clock_says(store, monkeypatch):
    times = iter(f"20{year}-01-01T00:00:00.000+00:00" for year in range(60, 10, -1))
    monkeypatch.setattr(session_store, "now_utc", lambda: next(times))
    for code in ("P1", "P2"):
        answer(store, store.enrol(code).code, 4)
    answer(store, "P1", 1)
    assert [(row.participant, row.more["token"]) for row in store.latest(2)] == [
        ("P1", "trial-3.1"),
        ("P2", "trial-2.1"),
    ]
    store.withdraw("P2")
    assert [row.more["token"] for row in store.latest(2)] == ["trial-3.1", "trial-2.1"]
    assert store.count == len(store.answers()) == 5


def test_times_that_cannot_be_are_left_out(store):
    code = store.enrol().code
    store.submit(code, "consent", {"consent": "agreed"}, rt_ms={"": -5.0, "consent": float("nan")})
    assert store.answers().numbers("rt_ms")[0] != store.answers().numbers("rt_ms")[0]


def test_withdrawal_deletes_every_trace_of_a_code(store):
    kept, gone = store.enrol("KEEP1").code, store.enrol("GONE1").code
    for code in (kept, gone):
        answer(store, code, 3)
        store.note(f"note about {code}", code=code)
    store.log_played(gone, store.page(gone).token, "A", sha256=HASH, level="physical", display="audio")
    assert store.withdraw(gone) == 3
    bytes_left = b"".join(path.read_bytes() for path in store.path.parent.glob("answers.sqlite*"))
    assert b"GONE1" not in bytes_left
    assert "GONE1" not in str(store._cache)  # nor in memory
    assert b"KEEP1" in bytes_left
    assert store.withdrawn == 1
    assert [note["participant"] for note in store.notes()] == ["KEEP1"]
    with pytest.raises(ParameterError, match="no participant has the code 'GONE1'"):
        store.submit(gone, "trial-2.1", {"which": "A"})
    assert store.enrol("NEXT1").number == 2


def test_what_another_keeps_open_is_told_at_a_withdrawal_and_goes_when_all_have_closed_it(store):
    store.note("x" * 4000, code=store.enrol("GONE1").code)
    store._connection.execute("PRAGMA busy_timeout = 0")
    with contextlib.closing(sqlite3.connect(store.path, isolation_level=None)) as other:
        other.execute("BEGIN")
        assert other.execute("SELECT count(*) FROM notes").fetchone() == (1,)
        with pytest.raises(DataError, match="log could not be emptied; close all programs that have it open"):
            store.withdraw("GONE1")
    store.close()
    [left] = store.path.parent.iterdir()
    assert b"GONE1" not in left.read_bytes()


def test_an_aborted_session_takes_no_answer_until_it_is_opened_again(store):
    code = store.enrol().code
    answer(store, code, 3)
    store.abort(code)
    assert store.progress()[0]["status"] == "aborted"
    with pytest.raises(ParameterError, match="was ended by the experimenter"):
        store.submit(code, "trial-2.1", {"which": "A"})
    store.reopen(code)
    assert store.submit(code, "trial-2.1", {"which": "A"}).stored


def test_a_study_that_was_ended_takes_nobody_and_nothing_until_it_goes_on(store):
    done, going = store.enrol("P1").code, store.enrol("P2").code
    answer(store, done, None)
    answer(store, going, 3)
    store.end()
    for refused in (
        store.enrol,
        lambda: store.page(going),
        lambda: store.submit(going, "trial-2.1", {"which": "A"}),
    ):
        with pytest.raises(ParameterError, match="the study was ended by the experimenter"):
            refused()
    assert store.page(done) is None
    assert (store.state(done), store.state(going)) == ("done", "aborted")
    when = store.ended
    store.end()
    assert store.ended == when is not None
    store.reopen_study()
    assert store.submit(going, "trial-2.1", {"which": "A"}).stored


def test_what_was_played_stands_in_the_answer(store):
    code = store.enrol().code
    answer(store, code, 2)
    for slot, digit in (("A", "a"), ("B", "b"), ("X", "c"), ("A", "d")):
        store.log_played(code, "trial-1.1", slot, sha256=digit * 64, level="gain=1", display="audio")
    store.submit(code, "trial-1.1", {"which": "A"})
    [row] = store.answers().where(token="trial-1.1")
    assert row.played_sha256 == "+".join(digit * 64 for digit in "dbc")
    assert len(store.played_log(code)) == 4
    with pytest.raises(ParameterError, match="is not at page"):
        store.log_played(code, "trial-1.1", "A", sha256=HASH, level="", display="")
    with pytest.raises(ParameterError, match="has the slots 'A', 'B', 'X', got 'C'"):
        store.log_played(code, "trial-2.1", "C", sha256=HASH, level="", display="")


@pytest.mark.parametrize("code", ["Hanako", "a b1", "x@y1", "1", "ä12", "P1'; --", "A" * 17 + "1"])
def test_what_may_be_a_name_is_no_code(store, code):
    with pytest.raises(ParameterError, match="letters and digits with a digit among them, never a name"):
        store.enrol(code)


def test_codes_are_taken_once_whatever_their_case_and_found_so(store):
    store.enrol("Ab12")
    with pytest.raises(ParameterError, match="code aB12 is taken"):
        store.enrol("aB12")
    assert store.participant("AB12").code == "Ab12"
    assert all(CODE.fullmatch(drawn_code()) for _ in range(50))


@pytest.mark.parametrize("first", [True, False])
def test_people_and_simulated_participants_are_kept_apart(store, first):
    store.enrol("P1", simulated=first)
    with pytest.raises(ParameterError, match="need a session folder of their own"):
        store.enrol("P2", simulated=not first)
    assert [one.code for one in store.participants()] == ["P1"]
    store.withdraw("P1")
    assert store.enrol("P2", simulated=not first).simulated is not first


def test_another_study_or_another_file_is_refused(store, make_study, tmp_path):
    with pytest.raises(
        DataError,
        match=r"was begun with another small than this small \(they differ in seed\); give another folder",
    ):
        SessionStore(store.path.parent, make_study(seed=4))
    with pytest.raises(DataError, match="no study was begun here"):
        SessionStore(tmp_path / "nothing")
    other = tmp_path / "other"
    other.mkdir()
    (other / "answers.sqlite").write_text("not a database, but text that is long enough to be looked at" * 9)
    with pytest.raises(DataError, match="file is not a database.; export the answers that can still be read"):
        SessionStore(other)


def test_a_page_is_there_once_by_a_rule_of_the_file(store):
    code = store.enrol().code
    answer(store, code, 1)
    with pytest.raises(sqlite3.IntegrityError):
        store._connection.execute("INSERT INTO pages VALUES (1, 2, 'consent', '{}', '{}')")


def test_a_full_disk_stores_nothing_of_a_page_and_the_rest_stays(store):
    code = store.enrol().code
    answer(store, code, 2)
    pages = store._connection.execute("PRAGMA page_count").fetchone()[0]
    store._connection.execute(f"PRAGMA max_page_count = {pages}")

    def filled():
        for _ in range(5):
            store.note("x" * 4000)

    with pytest.raises(DataError, match="nothing was stored: database or disk is full"):
        filled()
    assert tokens(store) == ["consent", "before"]
    store._connection.execute("PRAGMA max_page_count = 1000000")
    assert store.submit(code, "trial-1.1", {"which": "A"}).stored
