from dataclasses import dataclass

import pytest

from tactogram.studio.connections import MOST_FILES, gives_way, more_files


@dataclass(frozen=True)
class Held:
    """A connection as far as it matters to who gives way."""

    name: str
    sender: str = "a"
    waits: bool = True
    asked: bool = True
    since: float = 0.0

    @property
    def client(self):
        return (self.sender, 1) if self.sender else None


@pytest.mark.parametrize(
    ("held", "first"),
    [
        # Who has waited longest, of those that wait.
        ([Held("new", since=3), Held("old", since=1), Held("busy", waits=False)], "old"),
        # One on which nothing was asked, before one between two answers.
        ([Held("person", since=1), Held("idle", asked=False, since=2)], "idle"),
        # One of the sender's with the most, whoever came first.
        ([Held("person", "b", since=0), Held("x", since=1), Held("y", since=2)], "x"),
        ([Held("person", "", asked=False), Held("x", since=1), Held("y", since=2)], "x"),
        # All are answered: the newest.
        ([Held("person", waits=False, since=1), Held("new", waits=False, since=2)], "new"),
    ],
)
def test_who_gives_way(held, first):
    assert gives_way(set(held)).name == first


def test_more_files_may_be_open_where_the_system_allows_it():
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    low = min(256, hard)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (low, hard))
        more_files()
        assert resource.getrlimit(resource.RLIMIT_NOFILE)[0] == (
            MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
        )
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
