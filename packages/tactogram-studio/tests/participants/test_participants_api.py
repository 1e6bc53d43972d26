import asyncio
import io
import json
import shutil
import subprocess
import sys
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import httpx
import numpy as np
import pytest
import soundfile
from PIL import Image as Pillow

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import read_signal, write_signal
from tactogram_study.participants import routes, stimulus_routes
from tactogram_study.participants.refusals import NOT_STORED
from tactogram_study.participants.server_display import ServerDisplay
from tactogram_study.participants.sessions import SessionRegistry
from tactogram_study.participants.tickets import load_keys
from tactogram_study.session import store as session_store
from tactogram_study.session.participants import CODE, DIGITS, LETTERS, PAIRS
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.workflows.sessions import keep_origin
from tactogram_study.workflows.stimuli import StudyStimuli


def tokens(store, code):
    return [row.more["token"] for row in store.answers().where(participant=code)]


def test_a_study_is_taken_from_consent_to_end(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path, device={"px_per_mm": 6.1})
    states = []
    while (state := one.get("page").json())["page"] is not None:
        states.append(state)
        answered = one.answer(state["page"], device={"refresh_hz": 60}).json()
        assert answered["stored"]
    assert (state["state"], state["code"], state["title"], state["played_by"]) == (
        "done",
        one.code,
        "Small",
        "browser",
    )
    assert [found["page"]["kind"] for found in states] == ["consent", "questions", *["abx"] * 8, "questions"]
    assert [found["progress"] for found in states][2:4] == [{"trial": 1, "of": 8}, {"trial": 2, "of": 8}]
    rows = session.store.answers()
    assert tokens(session.store, one.code) == [found["page"]["token"] for found in states]
    assert set(rows.numbers("rt_ms")) == {700.0}
    assert {row.more["device_refresh_hz"] for row in rows} == {"60"}
    assert session.store.device(one.code)["px_per_mm"] == 6.1


def test_nothing_that_is_sent_says_which_stimulus_is_which(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    while (answered := one.get("page")).json()["page"] is not None:
        page = answered.json()["page"]
        sent = [
            answered,
            *(one.get("sound", token=page["token"], slot=slot["slot"]) for slot in page["slots"]),
        ]
        sent += [one.get("image", token=page["token"], slot=slot["slot"]) for slot in page["slots"]]
        sent.append(one.answer(page))
        for found in sent:
            assert found.status_code == 200
            assert found.headers["cache-control"] == "no-store"
            text = found.content + str(found.headers).encode()
            assert not any(
                name.encode() in text
                for name in ("cork", "tile", "recorded", "generated", ".wav", ".png", "gain=")
            )


def test_a_double_click_stores_once_and_the_first_answer_stays(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    token = one.go_to("abx")["token"]
    both = [one.post("answers", token=token, answers={"which": side}).json() for side in "AB"]
    assert [found["stored"] for found in both] == [True, False]
    assert both[0]["page"] == both[1]["page"]
    [row] = session.store.answers().where(token=token)
    assert row.answer == "A"


def test_clicks_at_the_same_instant_store_once(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    found = at_once(8, lambda _: one.answer(page).json()["stored"])
    assert sorted(found) == [False] * 7 + [True]
    assert Counter(tokens(session.store, one.code))[page["token"]] == 1


def at_once(count, do):
    """Return what ``do`` gives in as many threads, begun together."""
    barrier, found = threading.Barrier(count), []

    def run(number):
        barrier.wait()
        found.append(do(number))

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == count
    return found


def test_the_back_button_changes_nothing_and_a_page_to_come_is_refused(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    first = one.page()
    one.answer(first)
    present = one.page()
    back = one.answer(first).json()
    assert (back["stored"], back["page"]) == (False, present)
    ahead = one.post("answers", token="trial-3.1", answers={"which": "A"})
    assert (ahead.status_code, ahead.json()["error"]) == (
        409,
        "this page is out of date; reload it",
    )
    assert one.page() == present == one.page()


@pytest.mark.parametrize(
    ("answers", "message"),
    [
        ({}, "which: must be answered"),
        ({"which": "C"}, "which: must be one of A, B"),
        ({"x": "A"}, "asks which"),
    ],
)
def test_what_is_no_answer_is_refused_in_one_sentence_and_stores_nothing(
    tmp_path, opened, person, answers, message
):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    token = one.go_to("abx")["token"]
    refused = one.post("answers", token=token, answers=answers)
    assert (refused.status_code, message in refused.json()["error"]) == (400, True)
    assert token not in tokens(session.store, one.code)


def test_who_joins_twice_by_one_attempt_is_one_participant_even_after_a_crash(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    found = at_once(4, lambda _: person(client, session.join_path, attempt="drawn-by-the-page").code)
    assert len(set(found)) == len(session.store.participants()) == 1
    assert CODE.fullmatch(found[0])
    with Closing(SessionRegistry(tmp_path)) as again:
        client = opened.client_of(again)
        same = person(client, again.open(session.folder).join_path, attempt="drawn-by-the-page")
        assert same.code == found[0]
        other = person(client, session.join_path, attempt="drawn-by-another")
        assert other.code != found[0]
        same.answer()
        # Who has answered is nobody's first attempt: another person may have drawn the same.
    with Closing(SessionRegistry(tmp_path)) as again:
        again.open(session.folder)
        assert (
            person(opened.client_of(again), session.join_path, attempt="drawn-by-the-page").code != found[0]
        )


class Closing:
    def __init__(self, what):
        self.what = what

    def __enter__(self):
        return self.what

    def __exit__(self, *_):
        self.what.close()


def test_tickets_are_the_same_after_a_restart_and_differ_between_sessions(tmp_path, opened, person):
    sessions, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    other = sessions.begin("abx", tmp_path / "other")
    assert (
        load_keys(other.folder).ticket(one.code)
        != one.ticket
        == load_keys(session.folder).ticket(one.code.lower())
    )
    assert session.join_path == f"/join/{load_keys(session.folder).join}"
    with Closing(SessionRegistry(tmp_path)) as again:
        assert [found.folder for found in again.reopen([tmp_path, session.folder, other.folder])] == [
            session.folder,
            other.folder,
        ]
        one.client = opened.client_of(again)
        assert one.page() == page


def test_people_go_on_by_their_code_on_another_device(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    other = person(
        client, session.join_path, code=f" {one.code.lower()} ", language="ja", device={"px_per_mm": 9.5}
    )
    assert (other.code, other.ticket, other.page()["token"]) == (one.code, one.ticket, page["token"])
    assert other.get("page").json()["language"] == "ja"
    assert session.store.device(one.code)["px_per_mm"] == 9.5
    assert len(session.store.participants()) == 1


def test_wrong_codes_are_looked_up_one_after_the_other_and_the_right_one_among_them(
    tmp_path, opened, person, monkeypatch
):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    waiting, held_up_s = [], []

    async def sleep(seconds):
        waiting.append(seconds)
        await asyncio.sleep(0.001)
        assert len(waiting) == 1  # no other code is looked up meanwhile
        held_up_s.append(waiting.pop())

    monkeypatch.setattr(routes.anyio, "sleep", sleep)
    codes = [f"A{n % 10}A1A1" for n in range(70)]
    codes[35] = codes[69] = one.code
    with ThreadPoolExecutor(20) as pool:
        ask = partial(client.post, session.join_path)
        found = list(pool.map(lambda code: ask(json={"code": code, "language": "en"}), codes))
    assert [answered.status_code for answered in found] == [
        200 if code == one.code else 404 for code in codes
    ]
    assert held_up_s == [routes.WRONG_CODE_S] * 68


def test_a_drawn_code_is_rarely_guessed_in_an_hour():
    codes = (len(LETTERS) * len(DIGITS)) ** PAIRS
    assert codes == 1_358_954_496
    assert 100 * 3600 / routes.WRONG_CODE_S / codes < 0.0014  # of 100 participants


def test_a_sound_is_the_drive_and_is_logged_as_played(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    found = {slot: one.get("sound", token=page["token"], slot=slot) for slot in "ABX"}
    shown, hashes = session.store.page(one.code), []
    for slot, answered in found.items():
        samples, rate = soundfile.read(io.BytesIO(answered.content), dtype="float32")
        drive = StudyStimuli(session.study, tmp_path).played(shown.slot(slot))
        np.testing.assert_array_equal(samples.T, drive.drive.signal.samples)
        assert (rate, samples.shape[1], answered.headers["content-type"]) == (48_000, 2, "audio/wav")
        hashes.append(drive.sha256)
    one.answer(page)
    [row] = session.store.answers().where(token=page["token"])
    assert row.played_sha256 == "+".join(hashes)
    assert {log["level"] for log in session.store.played_log(one.code)} == {"gain=0.05"}
    behind = one.get("sound", token=page["token"], slot="A")
    assert (behind.status_code, behind.json()["error"][:7]) == (409, "this pa")
    assert one.get("sound", token=one.page()["token"]).status_code == 400


def test_a_sound_whose_page_is_answered_while_it_is_made_is_not_sent(tmp_path, opened, person, monkeypatch):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    token, wav_bytes = one.go_to("abx")["token"], stimulus_routes.wav_bytes

    def answered_meanwhile(drive):
        session.store.submit(one.code, token, {"which": "A"})
        return wav_bytes(drive)

    monkeypatch.setattr(stimulus_routes, "wav_bytes", answered_meanwhile)
    behind = one.get("sound", token=token, slot="A")
    assert (behind.status_code, session.store.played_log(one.code)) == (409, [])


def test_what_cannot_be_stored_is_told_without_where_it_lies_and_is_stored_when_sent_again(
    tmp_path, opened, person, caplog
):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.page()
    session.store._connection.execute("PRAGMA query_only=ON")
    refused = one.answer(page)
    assert (refused.status_code, refused.json()) == (503, {"error": NOT_STORED})
    assert f"{session.store.path}: nothing was stored: attempt to write a readonly" in caplog.text
    session.store._connection.execute("PRAGMA query_only=OFF")
    assert one.answer(page).json()["stored"]


def test_a_ticket_is_known_after_a_restart_whatever_is_asked_first(tmp_path, opened, person):
    sessions, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.page()
    sessions.close()
    session = sessions.open(session.folder)
    assert one.answer(page).json()["stored"]
    session.store.withdraw(one.code)
    assert (one.answer(page).status_code, one.get("page").status_code) == (404, 404)


def test_silence_is_as_long_as_what_it_stands_beside(tmp_path, opened, person):
    _, session, client = opened(
        tmp_path, "staircase", stimuli=[{"name": "cork", "file": "files/cork-recorded.wav"}]
    )
    one = person(client, session.join_path)
    page = one.go_to("staircase")
    found = [one.get("sound", token=page["token"], slot=slot) for slot in "AB"]
    sounds = [soundfile.read(io.BytesIO(answered.content))[0] for answered in found]
    assert sounds[0].shape == sounds[1].shape
    assert sorted(float(np.abs(sound).max()) > 0 for sound in sounds) == [False, True]
    assert len({str(sorted(set(answered.headers) - {"date"})) for answered in found}) == 1


def test_a_picture_is_sent_as_it_is_and_says_nothing_else(tmp_path, opened, person):
    _, session, client = opened(tmp_path, "rating")
    one = person(client, session.join_path)
    page = one.go_to("rating")
    slot = page["slots"][0]["slot"]
    answered = one.get("image", token=page["token"], slot=slot)
    picture = Pillow.open(io.BytesIO(answered.content))
    expected = StudyStimuli(session.study, tmp_path).image(session.store.page(one.code).slot(slot).stimulus)
    np.testing.assert_array_equal(np.asarray(picture), expected.pixels)
    assert picture.info == {}
    assert one.get("image", token=page["token"], slot="X").status_code == 400


def test_a_stimulus_that_fails_is_named_to_the_experimenter_only(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    for path in (tmp_path / "files").glob("*.wav"):
        path.write_bytes(b"RIFF")
    one = person(client, session.join_path)
    page = one.go_to("abx")
    answered = one.get("sound", token=page["token"], slot="A")
    assert (answered.status_code, answered.json()) == (
        503,
        {"error": "this stimulus cannot be played; please call the experimenter"},
    )
    [(name, why)] = [found for found in session.failures.items() if found[0]][:1]
    assert why.startswith(f"stimulus {name}: ")
    assert session.store.played_log(one.code) == []


def test_answers_about_a_file_that_says_it_is_simulated_are_marked(tmp_path, opened, person):
    _, session, client = opened(tmp_path, "rating")
    file = tmp_path / "files" / "cork-generated.wav"
    write_signal(file, read_signal(file), metadata={"simulated": True})
    one = person(client, session.join_path)
    while one.page() is not None:
        one.answer()
    rows = session.store.answers().where(design="rating")
    marked = {(row.stimulus, row.condition) for row in rows if "simulated_stimuli" in row.more}
    assert marked == {("cork", "generated")}
    assert len(rows.unique("stimulus")) == 2


def test_what_many_ask_for_at_once_is_made_once(tmp_path, opened, person, monkeypatch, until):
    _, session, client = opened(tmp_path)
    made, asked, all_asked = Counter(), [], threading.Event()
    original, at = StudyStimuli._rendered, stimulus_routes.current_page

    def counted(self, stimulus, gain_db):
        made[stimulus.name] += 1
        assert all_asked.wait(60)
        return original(self, stimulus, gain_db)

    def noted(*args):
        found = at(*args)
        asked.append(args)
        if len(asked) == 6:
            all_asked.set()
        return found

    monkeypatch.setattr(StudyStimuli, "_rendered", counted)
    monkeypatch.setattr(stimulus_routes, "current_page", noted)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    found = at_once(6, lambda n: one.get("sound", token=page["token"], slot="ABX"[n % 3]).status_code)
    assert found == [200] * 6
    until(lambda: len(made) == 4)
    assert made == dict.fromkeys(made, 1)
    assert len(made) == 4


def test_the_language_can_be_changed_on_the_way(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    changed = one.post("language", language="ja").json()
    assert (changed["language"], changed["title"]) == ("ja", "小さな研究")
    assert changed["page"]["questions"][0]["text"] == "参加に同意しますか。"
    assert one.post("language", language="fr").status_code == 400


def test_who_declines_is_asked_nothing_more(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    answered = one.post("answers", token="consent", answers={"consent": "declined"}).json()
    assert (answered["state"], answered["page"]) == ("declined", None)


def test_an_aborted_session_takes_no_answer_until_it_is_opened_again(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    session.store.abort(one.code)
    state = one.get("page").json()
    assert (state["state"], state["page"]) == ("aborted", None)
    assert one.answer(page).status_code == 409
    assert client.post(session.join_path, json={"code": one.code, "language": "en"}).status_code == 200
    session.store.reopen(one.code)
    assert one.answer(page).json()["stored"]


def test_after_withdrawal_a_ticket_is_nobody_s(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    one.go_to("abx")
    session.store.withdraw(one.code)
    assert [one.get("page").status_code, one.get("sound", token="trial-1.1", slot="A").status_code] == [
        404,
        404,
    ]
    assert client.get(f"/take/{one.ticket}").status_code == 404
    assert one.post("answers", token="trial-1.1", answers={}).status_code == 404


def test_pages_and_their_files_are_served(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    pages = [client.get(path) for path in (session.join_path, f"/take/{one.ticket}")]
    assert [page.headers["content-type"] for page in pages] == ["text/html; charset=utf-8"] * 2
    assert all("unsafe" not in page.headers["content-security-policy"] for page in pages)
    script = client.get("/participants/static/take.js")
    assert (script.headers["content-type"], script.headers["cache-control"]) == (
        "text/javascript; charset=utf-8",
        "no-cache",
    )
    offered = client.get(f"{session.join_path}/study").json()
    assert offered == {"title": {"ja": "小さな研究", "en": "Small"}, "languages": ["ja", "en"], "open": True}
    gone = client.get("/join/nothing-that-was-ever-drawn")
    assert (gone.status_code, "<p class='lead' lang='de'>Diese Seite" in gone.text) == (404, True)


def test_a_display_that_no_browser_plays_is_refused_before_anything_is_written(tmp_path, write_study):
    study = write_study(tmp_path, display="voice-coil", level="physical")
    with (
        Closing(SessionRegistry(tmp_path)) as sessions,
        pytest.raises(ParameterError, match=r"voice-coil takes V .* 'server'"),
    ):
        sessions.begin(study, tmp_path / "session")
    assert not (tmp_path / "session").exists()


def test_a_session_that_no_browser_plays_can_be_looked_at_and_sends_no_sound(
    tmp_path, opened, person, write_study
):
    study = write_study(tmp_path, display="voice-coil", level="peak=0.8")
    folder = tmp_path / "session"
    with SessionStore(folder, Study.load(study)):  # `begin_session` refuses it
        keep_origin(folder, study)
    with Closing(SessionRegistry(tmp_path)) as sessions:
        session = sessions.open(folder)
        one = person(opened.client_of(sessions), session.join_path)
        page = one.go_to("abx")
        assert one.get("sound", token=page["token"], slot="A").status_code == 503
        assert any("voice-coil takes V" in why for why in session.failures.values())


def test_the_server_s_display_plays_to_one_at_a_time_and_stops(tmp_path, opened, person, until):
    sessions, session, client = opened(tmp_path, played_by="server")
    one, two = person(client, session.join_path), person(client, session.join_path)
    page, other = one.go_to("abx"), two.go_to("abx")
    played = one.post("play", token=page["token"], slot="A").json()
    assert played == {"state": "ended", "simulated_device": True}
    drive, rendered = session.stimuli.drive(session.store.page(one.code), "A")
    assert [log["sha256"] for log in session.store.played_log(one.code)] == [rendered.sha256]
    display = session.stimuli.display(session.store.page(one.code).slot("A").stimulus)
    long = drive.with_samples(np.tile(drive.samples, 200))
    ended = []
    playing = threading.Thread(target=lambda: ended.append(sessions.display.play(one.ticket, long, display)))
    playing.start()
    until(lambda: sessions.display._playing is not None)
    busy = two.post("play", token=other["token"], slot="A")
    assert (busy.status_code, "another participant" in busy.json()["error"]) == (423, True)
    assert two.post("stop").json() == {"stopped": False}
    assert one.post("stop").json() == {"stopped": True}
    playing.join(5)
    assert ended[0]["state"] == "stopped"
    assert two.post("play", token=other["token"], slot="A").json()["state"] == "ended"
    assert one.get("sound", token=page["token"], slot="A").status_code == 400


def test_a_display_that_the_device_cannot_drive_is_refused_beforehand(tmp_path, opened):
    _, session, _ = opened(tmp_path, played_by="server", display="voice-coil", level="peak=1")
    [display] = session.stimuli.displays
    assert display.name == "voice-coil"
    ServerDisplay("null").check(display)
    ServerDisplay("audio", 10.0).check(display)
    with pytest.raises(ParameterError, match="voice-coil is driven in V; measure .* `full_scale`"):
        ServerDisplay("audio").check(display)


def test_a_clock_that_is_set_back_changes_nothing(tmp_path, opened, person, monkeypatch):
    _, session, client = opened(tmp_path)
    times = iter(f"20{year}-01-01T00:00:00.000+00:00" for year in range(90, 10, -1))
    monkeypatch.setattr(session_store, "now_utc", lambda: next(times))
    one = person(client, session.join_path)
    one.go_to("abx")
    shown = [one.answer().json()["page"]["trial"] for _ in range(3)]
    assert shown == [2, 3, 4]
    assert tokens(session.store, one.code) == ["consent", "before", "trial-1.1", "trial-2.1", "trial-3.1"]


def test_a_power_cut_keeps_what_was_acknowledged(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    one.go_to("abx")
    one.answer()
    present, kept = one.page(), tokens(session.store, one.code)
    cut = tmp_path / "cut"
    # What is on the disk at this instant, without the index in memory and with a torn page at the log's end.
    shutil.copytree(session.folder, cut, ignore=shutil.ignore_patterns("*-shm"))
    with (cut / "answers.sqlite-wal").open("ab") as file:
        file.write(b"\x37" * 2500)
    with Closing(SessionRegistry(tmp_path)) as again:
        assert tokens(again.open(cut).store, one.code) == kept
        one.client = opened.client_of(again)
        assert one.page() == present
        assert one.answer(present).json()["stored"]


def take_until_gone(one, acknowledged):
    """Answer page after page until the server is gone or the study at its end."""
    try:
        page = one.page()
        while page is not None:
            answered = one.answer(page).json()
            acknowledged.append((one.code, page["token"]))
            page = answered["page"]
    except httpx.TransportError:
        return


@pytest.mark.slow
def test_a_kill_at_any_instant_loses_no_acknowledged_answer_and_stores_none_twice(
    tmp_path, write_study, process_over, person, until
):
    study = write_study(tmp_path, design={"kind": "abx", "repeats": 24}, played_by="browser")
    folder, acknowledged, people = tmp_path / "session", [], []
    for life in range(3):
        with process_over(tmp_path, study, folder) as (process, address):
            base, _, key = address.partition("/join/")
            with httpx.Client(base_url=base, timeout=60) as client:
                people = people or [person(client, f"/join/{key}") for _ in range(3)]
                for one in people:
                    one.client = client
                threads = [
                    threading.Thread(target=take_until_gone, args=(one, acknowledged)) for one in people
                ]
                for thread in threads:
                    thread.start()
                wanted = len(acknowledged) + 25
                if life < 2:
                    until(lambda n=wanted: len(acknowledged) >= n)
                    process.kill()
                for thread in threads:
                    thread.join()
    with SessionStore(folder) as store:
        assert len(store.participants()) == 3
        for one in people:
            stored = tokens(store, one.code)
            assert len(stored) == len(set(stored)) == 2 + 48 + 1
            assert {token for code, token in acknowledged if code == one.code} <= set(stored)
            assert store.page(one.code) is None


def test_participants_pages_start_without_torch(tmp_path, write_study):
    study = write_study(tmp_path)
    script = (
        "import sys, pathlib\n"
        "from tactogram_study.participants.routes import make_participant_app\n"
        "from tactogram_study.participants.sessions import SessionRegistry\n"
        "sessions = SessionRegistry(pathlib.Path(sys.argv[1]))\n"
        "session = sessions.begin(sys.argv[2], pathlib.Path(sys.argv[1]) / 'session')\n"
        "make_participant_app(sessions)\n"
        "code = session.store.enrol().code\n"
        "for _ in range(2):\n"
        "    page = session.store.page(code)\n"
        "    answers = {one.key: one.question.options[0].value for one in page.questions}\n"
        "    page = session.store.submit(code, page.token, answers).page\n"
        "session.stimuli.drive(page, 'A')\n"
        "print([name for name in ('torch', 'nicegui') if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path), str(study)], capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout.replace("'", '"')) == []


@pytest.mark.parametrize("text", ["{", "[]", "{}", "\xff"])
def test_a_damaged_origin_is_refused_in_a_line(tmp_path, opened, text):
    sessions, session, _ = opened(tmp_path)
    sessions.close()
    (session.folder / "origin.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(DataError, match=r"origin\.json: .*; run the study again with its file") as told:
        sessions.open(session.folder)
    assert "\n" not in str(told.value)
