from dataclasses import dataclass

import pytest

from tactogram.studio.connections import MOST_FILES, gives_way, limits_here


@dataclass(frozen=True)
class Held:
    """A connection as far as it matters to who gives way."""

    name: str
    sender: str = "a"
    waits: bool = True
    asked: bool = True
    since: float = 0.0


MANY = [Held(f"x{n}", asked=n % 2 == 0, since=-n) for n in range(24)]


@pytest.mark.parametrize(
    ("held", "first"),
    [
        # Who has waited longest, of those that wait.
        ([Held("new", since=3), Held("old", since=1), Held("busy", waits=False)], ["old"]),
        # One on which nothing was asked, before one between two answers.
        ([Held("person", since=1), Held("idle", asked=False, since=2)], ["idle"]),
        # One of the sender's with the most, whoever came first.
        ([Held("person", "b", since=0), Held("x", since=1), Held("y", since=2)], ["x"]),
        ([Held("person", "", asked=False), Held("x", since=1), Held("y", since=2)], ["x"]),
        # An eighth of many.
        ([Held("person", "b", asked=False, since=-99), *MANY], ["x23", "x21", "x19"]),
        # All are answered: the newest.
        ([Held("person", waits=False, since=1), Held("new", waits=False, since=2)], ["new"]),
    ],
)
def test_who_gives_way(held, first):
    assert [one.name for one in gives_way(set(held))] == first


def test_connections_leave_files_to_the_rest(monkeypatch):
    resource = pytest.importorskip("resource")
    has = [256, 400]
    monkeypatch.setattr(resource, "getrlimit", lambda which: tuple(has))
    monkeypatch.setattr(resource, "setrlimit", lambda which, limits: has.__setitem__(0, limits[0]))
    assert (limits_here().connections, has) == (200, [400, 400])
    has[:] = [256, 10_000]
    assert (limits_here().connections, has) == (512, [MOST_FILES, 10_000])
    has[:] = [256, resource.RLIM_INFINITY]
    assert (limits_here().connections, has[0]) == (512, MOST_FILES)
    has[:] = [resource.RLIM_INFINITY] * 2
    assert (limits_here().connections, has[0]) == (512, resource.RLIM_INFINITY)
