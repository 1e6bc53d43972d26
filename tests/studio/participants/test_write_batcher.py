import asyncio
import sqlite3
import threading
from functools import partial

import pytest

from tactogram.errors import DataError, ParameterError

CONSENT = {"consent": "agreed"}


class Slow:
    """A write that says when it is in its transaction, and goes on when it may."""

    def __init__(self):
        self.reached, self.may = threading.Event(), threading.Event()

    def __call__(self):
        self.reached.set()
        assert self.may.wait(60)
        return "slow"


@pytest.fixture
def session(tmp_path, opened):
    return opened(tmp_path)[1]


def consent(session, number, responses=CONSENT):
    return partial(session.store.submit, session.store.enrol(f"P{number}").code, "consent", responses)


def commits(session):
    """Return a list that grows by one with each transaction that is committed."""
    found = []
    trace = session.store._connection.set_trace_callback
    trace(lambda text: found.append(text) if text == "COMMIT" else None)
    return found


def on_disk(session):
    """Return how many answers another process would find."""
    with sqlite3.connect(session.folder / "answers.sqlite") as other:
        [[count]] = other.execute("SELECT count(*) FROM answers")
    other.close()
    return count


async def begun(session, *writes):
    """Begin writes, and give each time to get into the line."""
    tasks = [asyncio.create_task(session.writes.store(write)) for write in writes]
    await asyncio.sleep(0)
    return tasks


async def slow_one(session):
    """Begin a slow write, and return it and its task when it is in its transaction."""
    slow = Slow()
    [task] = await begun(session, slow)
    assert await asyncio.to_thread(slow.reached.wait, 10)
    return slow, task


def test_answers_that_wait_together_are_one_transaction_and_each_is_stored_once(session):
    writes = [consent(session, number) for number in range(5)]
    committed = commits(session)

    async def run():
        slow, first = await slow_one(session)
        tasks = await begun(session, *writes)
        slow.may.set()
        return await first, await asyncio.gather(*tasks)

    first, found = asyncio.run(run())
    assert (first, [one.stored for one in found]) == ("slow", [True] * 5)
    assert len(committed) == 2
    assert sorted(row.participant for row in session.store.answers()) == [f"P{n}" for n in range(5)]


def test_nobody_is_told_before_it_is_on_the_disk(session):
    write, later = consent(session, 1), Slow()

    async def run():
        slow, first = await slow_one(session)
        told, last = await begun(session, write, later)
        slow.may.set()
        await first
        assert await asyncio.to_thread(later.reached.wait, 10)  # written before, and not committed
        before = told.done(), on_disk(session)
        later.may.set()
        await last
        return before, (await told).stored, on_disk(session)

    assert asyncio.run(run()) == ((False, 0), True, 1)


def test_a_refused_answer_among_others_is_told_and_harms_none(session):
    writes = [consent(session, 1), consent(session, 2, {"consent": "perhaps"}), consent(session, 3)]

    async def run():
        tasks = await begun(session, *writes)
        return await asyncio.gather(*tasks, return_exceptions=True)

    one, refused, another = asyncio.run(run())
    assert (one.stored, another.stored) == (True, True)
    assert isinstance(refused, ParameterError)
    assert [row.participant for row in session.store.answers()] == ["P1", "P3"]


def test_what_fails_for_all_is_told_to_all_and_the_next_are_stored(session, monkeypatch):
    writes = [consent(session, number) for number in (1, 2)]

    def full(_):
        raise DataError("nothing was stored: disk is full")

    async def run():
        with monkeypatch.context() as change:
            change.setattr(session.store, "write_together", full)
            failed = await asyncio.gather(*await begun(session, *writes), return_exceptions=True)
        return failed, await session.writes.store(writes[0])

    failed, after = asyncio.run(run())
    assert [str(error) for error in failed] == ["nothing was stored: disk is full"] * 2
    assert after.stored


def test_where_no_thread_can_be_had_all_are_told_and_nobody_waits_for_ever(session, monkeypatch):
    write = consent(session, 1)

    async def none(*args, **kwargs):
        raise RuntimeError("can't start new thread")

    async def run():
        with monkeypatch.context() as change:
            change.setattr("anyio.to_thread.run_sync", none)
            [task] = await begun(session, write)
            await asyncio.wait([task], timeout=60)
        assert isinstance(task.exception(), RuntimeError)
        return await session.writes.store(write)

    assert asyncio.run(run()).stored


def test_the_answer_of_who_has_gone_is_stored_and_the_others_are_told(session):
    writes = [consent(session, 1), consent(session, 2)]

    async def run():
        slow, first = await slow_one(session)
        gone, other = await begun(session, *writes)
        gone.cancel()
        slow.may.set()
        return await asyncio.gather(first, gone, other, return_exceptions=True)

    first, gone, other = asyncio.run(run())
    assert (first, type(gone), other.stored) == ("slow", asyncio.CancelledError, True)
    assert session.store.count == 2
