"""Sessions: accepted takes are in the store, whatever happens, and the session continues where it stopped."""

import io
import os
import resource
import signal
import sys
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from tactogram.datasets import open_store
from tactogram.datasets.store.store import problems
from tactogram.datasets.store.writing import append_recording, recover_store
from tactogram.errors import DataError, ParameterError
from tactogram_capture.session.console import LineConsole
from tactogram_capture.session.journal import Journal
from tactogram_capture.session.plan import SessionPlan
from tactogram_capture.session.session import RecordingSession, session_folder
from tactogram_capture.session.take import restored
from tactogram_capture.source import SourceLost


def test_the_journal_records_each_event(tmp_path, played):
    run(tmp_path / "s", played(), answers="b\nr\na\nq\n", log="raw-001.log")
    with Journal(session_folder(tmp_path / "s", "one")) as journal:
        assert [entry["event"] for entry in journal.events] == ["begun", "opened", "take", "take", "closed"]
        redone, accepted = journal.of("take")
    assert (redone["decision"], accepted["decision"]) == ("redo", "accept")
    assert (redone["attempt"], accepted["attempt"]) == (1, 2)
    assert accepted["verdict"]["good"]
    [recording] = stored(tmp_path / "s")
    assert recording.labels["log"] == "raw-001.log"
    assert int(recording.labels["first_index"]) == accepted["first_index"]


PLAN = {
    "materials": ["cork", "tile"], "speeds_mm_s": [100, 200], "seconds": 0.5, "countdown_s": 0, "metronome": False,
    "seed": 3, "subject": "s01", "force_n": 0.5,
}  # fmt: skip


def run(store, source, *, plan=PLAN, answers=None, name="one", **options):
    """Run a session; return its result and its output."""
    said = io.StringIO()
    console = LineConsole(None if answers is None else io.StringIO(answers), said)
    with Journal(session_folder(store, name)) as journal:
        session = RecordingSession(SessionPlan.of(plan), store, name, source, console, journal, **options)
        return session.run(), said.getvalue()


def order(plan=PLAN):
    return [(t.material, t.speed_mm_s) for t in SessionPlan.of(plan).trials()]


def stored(path):
    store = open_store(path)
    return [store.read(info.id) for info in store.index]


def test_a_session_records_its_plan_in_its_order(tmp_path, played):
    result, _ = run(tmp_path / "s", played())
    recordings = stored(tmp_path / "s")
    assert result == {"accepted": 4, "redone": 0, "skipped": 0, "left": 0, "stopped": None}
    assert [(r.material, r.speed_mm_s) for r in recordings] == order()
    first = recordings[0]
    assert (first.session, first.subject, first.force_n, first.simulated) == ("one", "s01", 0.5, True)
    assert first.labels["trial"] == "1"
    assert len(first.stream("acceleration")) == 165
    assert problems(open_store(tmp_path / "s")) == []


def test_stored_samples_equal_the_received_ones(tmp_path, played):
    source = played(lost=[3, 22, 40])
    run(tmp_path / "s", source, plan=PLAN | {"limits": {"most_lost": 1, "longest_gap_s": 9}})
    played_back = np.concatenate(source.played, axis=1)
    for recording in stored(tmp_path / "s"):
        first = int(recording.labels["first_index"])
        np.testing.assert_array_equal(restored(recording), played_back[:, first : first + 165])


def test_redo_skip_and_stop(tmp_path, played):
    result, said = run(tmp_path / "s", played(), answers="b\nr\na\nb\ns\ns\nq\n")
    # Begin, redo, accept; begin, skip after all; skip; stop.
    assert result == {
        "accepted": 1, "redone": 1, "skipped": 2, "left": 1, "stopped": "stopped by the experimenter",
    }  # fmt: skip
    assert [r.labels["trial"] for r in stored(tmp_path / "s")] == ["1"]
    result, said = run(tmp_path / "s", played(seed=1))
    assert "1 of 4 takes are in the store, 2 skipped" in said
    assert (result["accepted"], result["left"]) == (1, 0)
    assert [r.labels["trial"] for r in stored(tmp_path / "s")] == ["1", "4"]


def test_the_end_of_the_answers_stops_the_session(tmp_path, played):
    result, _ = run(tmp_path / "s", played(), answers="b\na\n")
    assert (result["accepted"], result["left"]) == (1, 3)


def test_unattended_a_bad_take_is_redone_and_then_skipped(tmp_path, played):
    result, said = run(tmp_path / "s", played(scale=0.001))
    assert (result["accepted"], result["skipped"], result["redone"]) == (0, 4, 8)
    assert "was the surface stroked?" in said
    assert not (tmp_path / "s").exists()


def test_a_bad_take_can_be_accepted_and_is_marked(tmp_path, played):
    run(tmp_path / "s", played(scale=0.001), answers="b\na\nq\n")
    [recording] = stored(tmp_path / "s")
    assert recording.labels["verdict"].startswith("bad: ")


@pytest.mark.parametrize("answers", ["b\na\nq\n", "s\nq\n"])
def test_another_plan_is_refused_once_a_take_is_decided(tmp_path, played, answers):
    run(tmp_path / "s", played(), answers=answers)
    with pytest.raises(DataError, match="another plan"):
        run(tmp_path / "s", played(), plan=PLAN | {"materials": ["cork", "wool"]})


def test_a_session_without_takes_may_have_another_plan(tmp_path, played):
    run(tmp_path / "s", played(), answers="q\n")
    other = PLAN | {"materials": ["cork", "wool"]}
    run(tmp_path / "s", played(), plan=other, answers="b\na\nq\n")
    result, said = run(tmp_path / "s", played(), plan=other)
    assert (result["accepted"], result["left"]) == (3, 0)
    assert "1 of 4 takes are in the store" in said
    assert [(r.material, r.speed_mm_s) for r in stored(tmp_path / "s")] == order(other)


def test_two_sessions_share_a_store(tmp_path, played):
    run(tmp_path / "s", played(), name="one")
    run(tmp_path / "s", played(seed=1), name="two")
    assert [r.session for r in stored(tmp_path / "s")] == ["one"] * 4 + ["two"] * 4


def test_a_session_is_used_by_one_process_at_a_time(tmp_path, played):
    with Journal(session_folder(tmp_path / "s", "one")), pytest.raises(DataError, match="another process"):
        run(tmp_path / "s", played())


def test_a_session_name_that_cannot_be_a_folder_is_refused(tmp_path):
    with pytest.raises(ParameterError, match="session's name"):
        session_folder(tmp_path / "s", "../x")


def test_a_pulled_plug_ends_the_session_and_keeps_accepted_takes(tmp_path, played):
    # 17 packets a take and one at each question: the plug is pulled in the third take.
    source = played(packets=50, end="pulled")
    with pytest.raises(SourceLost, match="2 takes of this run are in .* continue"):
        run(tmp_path / "s", source)
    result, _ = run(tmp_path / "s", played(seed=1))
    assert result["accepted"] == 2
    assert [(r.material, r.speed_mm_s) for r in stored(tmp_path / "s")] == order()


def test_a_plug_pulled_at_the_question_loses_no_take(tmp_path, played):
    # One packet at the first question, 17 of the take, and none at the question whether it is good.
    with pytest.raises(SourceLost, match="1 takes of this run"):
        run(tmp_path / "s", played(packets=18, end="pulled"))
    assert len(stored(tmp_path / "s")) == 1


def test_a_source_that_repeats_the_same_samples_is_detected(tmp_path, played):
    run(tmp_path / "s", played(), answers="b\na\nq\n")
    result, said = run(tmp_path / "s", played(), answers="b\na\nq\n")
    assert "holds the same samples already, as one/0001" in said
    assert result["accepted"] == 0
    assert len(stored(tmp_path / "s")) == 1


def test_a_full_disk_stores_no_partial_take_and_keeps_it_available(tmp_path, played):
    # The limit on a file's size stands for a full disk: writes fail in the middle of a file.
    run(tmp_path / "s", played(), answers="b\na\nq\n")
    before = sorted(p.name for p in (tmp_path / "s").iterdir())
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

    class Asked(LineConsole):
        def say(self, text):
            if text.startswith("NOT stored"):
                resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))  # somebody makes room
                assert sorted(p.name for p in (tmp_path / "s").iterdir()) == before
                assert problems(open_store(tmp_path / "s")) == []
            super().say(text)

    said = io.StringIO()
    with Journal(session_folder(tmp_path / "s", "one")) as journal:
        plan = SessionPlan.of(PLAN)
        console = Asked(io.StringIO("b\na\na\nq\n"), said)
        session = RecordingSession(plan, tmp_path / "s", "one", played(seed=1), console, journal)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
        try:
            result = session.run()
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "File too large" in said.getvalue().partition("NOT stored")[2]
    assert result["accepted"] == 1
    assert len(stored(tmp_path / "s")) == 2
    assert problems(open_store(tmp_path / "s")) == []


def test_a_session_without_an_experimenter_fails_where_a_take_cannot_be_stored(tmp_path, played):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with Journal(session_folder(tmp_path / "s", "one")) as journal:
        console = LineConsole(None, io.StringIO())
        session = RecordingSession(SessionPlan.of(PLAN), tmp_path / "s", "one", played(), console, journal)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
        try:
            with pytest.raises(OSError, match="File too large"):
                session.run()
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not (tmp_path / "s" / "dataset.json").exists()


def test_each_take_is_shown_with_its_classification(tmp_path, played):
    heard = []

    def recognise(signal):
        heard.append((len(signal), signal.rate))
        return {"cork": 0.25, "tile": 0.75}

    _, said = run(tmp_path / "s", played(lost=[3]), answers="b\na\nq\n", recognise=recognise)
    assert "classified as tile (0.75)" in said
    assert heard == [(165, 330.0)]


def test_a_simulated_device_gets_each_trial(tmp_path, played):
    told = []
    run(tmp_path / "s", played(), on_trial=lambda trial: told.append((trial.material, trial.speed_mm_s)))
    assert told == order()


class Killer:
    """Kills this process after the ``at``-th step towards the disk."""

    def __init__(self, at):
        self.at, self.steps = at, 0

    def around(self, step):
        def killing(*arguments, **options):
            self.steps += 1
            number = self.steps
            try:
                return step(*arguments, **options)
            finally:  # also of a step that fails, such as the removal of what is not there
                if number == self.at:
                    os.kill(os.getpid(), signal.SIGKILL)

        return killing

    def hold(self):
        os.fsync, os.write = self.around(os.fsync), self.around(os.write)
        Path.replace, Path.rename = self.around(Path.replace), self.around(Path.rename)
        Path.unlink, Path.mkdir = self.around(Path.unlink), self.around(Path.mkdir)


def killed(work):
    """Run ``work`` in a process of its own; return whether it was killed."""
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        try:
            work()
        except BaseException:
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        assert os.WTERMSIG(status) == signal.SIGKILL
        return True
    assert os.WEXITSTATUS(status) == 0
    return False


@pytest.mark.parametrize("first", [1, 2, 3])
def test_killed_at_any_step_a_session_continues_without_partial_files(tmp_path, played, first):
    plan = PLAN | {"materials": ["cork"], "seconds": 0.1}
    for step in count(first, 3):
        store = tmp_path / f"s{step}"

        def session(step=step, store=store):
            Killer(step).hold()
            run(store, played(), plan=plan)

        was_killed = killed(session)
        found, _ = recover_store(store)
        accepted = [] if found is None else [(r.material, r.speed_mm_s) for r in stored(store)]
        assert accepted == order(plan)[: len(accepted)]
        result, _ = run(store, played(seed=1), plan=plan)
        assert result["accepted"] == len(order(plan)) - len(accepted)
        assert [(r.material, r.speed_mm_s) for r in stored(store)] == order(plan)
        check(store)
        if not was_killed:
            break
    assert step > 30


def check(path):
    """The folder contains the files named by ``dataset.json``, complete, and nothing else."""
    store = open_store(path)
    assert problems(store) == []
    facts = store.facts
    assert {p.name for p in path.iterdir()} == {"dataset.json", facts.ids} | {s.file for s in facts.shards}
    assert not list(path.parent.glob(f"{path.name}.part-*"))


def test_another_process_may_add_to_the_store_meanwhile(tmp_path, played, monkeypatch):
    run(tmp_path / "s", played(), answers="b\na\nq\n")
    run(tmp_path / "t", played(seed=1), answers="b\na\nq\n")
    run(tmp_path / "u", played(seed=2), answers="b\na\nq\n")
    [mine], [theirs] = stored(tmp_path / "t"), stored(tmp_path / "u")
    from tactogram.datasets.store import writing

    opened = []

    def opening(path):
        store = open_store(path)
        if not opened:
            opened.append(path)
            append_recording(path, theirs, name="s", licence="x")
        return store

    monkeypatch.setattr(writing, "open_store", opening)
    append_recording(tmp_path / "s", mine, name="s", licence="x")
    assert {mine.id, theirs.id} < {r.id for r in stored(tmp_path / "s")}
    assert len(stored(tmp_path / "s")) == 3
    assert problems(open_store(tmp_path / "s")) == []


def test_all_takes_of_a_session_have_one_rate_despite_varying_measurements(tmp_path, played):
    source = played(rate=None, measured=329.0)
    facts = source.facts
    source.facts = lambda: facts() | {"rate": {"hz": 329 + source.packet / 500, "low": 328.9, "high": 329.5}}
    run(tmp_path / "s", source, answers="b\na\nb\na\nq\n")
    run(tmp_path / "s", played(seed=1, rate=None, measured=329.2))
    recordings = stored(tmp_path / "s")
    assert len({r.stream("acceleration").rate for r in recordings}) == 1
    assert len({r.history[0] for r in recordings}) > 2


def test_a_log_that_cannot_be_written_loses_no_take(tmp_path, played):
    source = played()
    read = source.read

    def failing(timeout_s=0.1):
        # The first question's packet and the 17 of the take come; then the disk is full.
        if source.packet >= 18:
            raise DataError("raw-001.log: the log cannot be written (No space left on device)")
        return read(timeout_s)

    source.read = failing
    with pytest.raises(DataError, match="No space left"):
        run(tmp_path / "s", source)
    assert len(stored(tmp_path / "s")) == 1


def test_an_interrupt_keeps_accepted_takes(tmp_path, played):
    source = played()
    read = source.read

    def interrupted(timeout_s=0.1):
        if source.packet == 30:
            raise KeyboardInterrupt
        return read(timeout_s)

    source.read = interrupted
    result, _ = run(tmp_path / "s", source)
    assert (result["accepted"], result["stopped"], result["left"]) == (1, "interrupted", 3)
