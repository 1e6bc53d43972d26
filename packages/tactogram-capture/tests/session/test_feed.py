"""The feed of a session: a source that sends nothing."""

import os

import pytest

from tactogram_capture import SourceLost, open_source
from tactogram_capture.session import feed

tty = pytest.importorskip("tty")


@pytest.fixture(name="port")
def port_fixture():
    """Return a handle at which a board prints, and the port at which it is read."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize(
    ("printed", "told"),
    [
        (b"", "nothing arrives: is it the board's port"),
        (
            bytes(range(128, 256)) * 4,
            "what arrives is not lines of numbers: is 115200 the baud rate of .*baud=9600'`",
        ),
        (b"1,2\n" * 5, "4 lines of numbers do not suffice to tell the columns"),
    ],
)
def test_port_without_samples_says_what_to_do_in_one_line(port, monkeypatch, printed, told):
    monkeypatch.setattr(feed, "START_S", 0.1)
    with open_source(f"serial:{port[1]}") as source:
        os.write(port[0], printed)
        listening = feed.Feed(source, silence_s=0.1)
        with pytest.raises(SourceLost, match=rf"^[^\n]*: no samples for 0\.\d s; {told}[^\n]*$"):
            [listening.poll(0.05) for _ in range(99)]
