"""Answers from a pipe, a script or keys; and the panel."""

import io
import os
import threading

import pytest
from rich.console import Console as RichConsole

from tactogram_capture.session.console import CaptureStatus, LineConsole, TerminalConsole, panel
from tactogram_capture.session.feed import MeterReading

KEYS = {"a": "accept", "r": "redo", "q": "stop"}


def ask(console, default="a", idle=lambda: None):
    return console.ask("keep it?", KEYS, default=default, idle=idle)


def test_a_script_answers_line_by_line_and_its_end_stops():
    console = LineConsole(io.StringIO("redo\n\nx\nA\n"), io.StringIO())
    assert [ask(console) for _ in range(4)] == ["r", "a", "a", "q"]


def test_an_invalid_answer_repeats_the_question():
    said = io.StringIO()
    ask(LineConsole(io.StringIO("x\na\n"), said))
    assert "answer must be one of a, r, q, got 'x'" in said.getvalue()


def test_yes_takes_the_default():
    assert ask(LineConsole(None, io.StringIO()), default="r") == "r"


def test_the_source_is_read_until_an_answer():
    # Lines that come in one piece, and one that comes later, in two.
    reading, writing = os.pipe()
    os.write(writing, b"r\na\n")
    idled = []

    def idle():
        idled.append(1)
        if len(idled) == 10:
            os.write(writing, b"re")
        if len(idled) == 20:
            os.write(writing, b"do\n")
            os.close(writing)

    with os.fdopen(reading) as pipe:
        console = LineConsole(pipe, io.StringIO())
        assert [ask(console, idle=idle) for _ in range(4)] == ["r", "a", "r", "q"]
    assert len(idled) >= 20


def shown(status):
    console = RichConsole(width=100, record=True, file=io.StringIO())
    console.print(panel(status))
    return console.export_text()


def test_the_panel_shows_level_clipping_losses_and_rate():
    levels = MeterReading(rms=2.5, peak=156.9, full_scale=156.9, clipped=True, lost=20, rate=329.87)
    text = shown(CaptureStatus("take 3 of 9: tile", "recording", "2.0 of 10 s", 0.2, levels))
    for expected in (
        "take 3 of 9: tile",
        "recording",
        "2.0 of 10 s",
        "2.500 rms",
        "CLIPPED",
        "329.87 Hz",
        "lost so far 20",
    ):
        assert expected in text
    quiet = MeterReading(rms=0.0, peak=0.0, full_scale=None, clipped=False, lost=0, rate=None)
    assert "CLIPPED" not in shown(CaptureStatus("x", "countdown", "3.0 s", 0.0, quiet))
    assert "unknown yet" in shown(CaptureStatus("x", "countdown", "3.0 s", 0.0, quiet))


@pytest.mark.parametrize(("typed", "answer"), [(b"r", "r"), (b"\n", "a"), (b"x\x04", "q"), (b"Q", "q")])
def test_keys_need_no_enter_and_the_terminal_is_restored(monkeypatch, typed, answer):
    import termios

    master, slave = os.openpty()
    before = termios.tcgetattr(slave)
    with os.fdopen(slave, "r") as stdin:
        monkeypatch.setattr("sys.stdin", stdin)
        console = TerminalConsole()
        timer = threading.Timer(0.05, os.write, (master, typed))
        timer.start()
        idled = []

        def idle():
            idled.append(1)
            threading.Event().wait(0.005)
            if typed == b"x\x04" and len(idled) == 40:
                os.write(master, b"\x04")

        assert ask(console, idle=idle) == answer
        timer.join()
        assert termios.tcgetattr(stdin.fileno()) == before
    os.close(master)
