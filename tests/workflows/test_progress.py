"""Progress on terminals and elsewhere."""

import io
import json

from rich.console import Console

from tactogram.cli import main
from tactogram.workflows.progress import ProgressLines, progress_bars


def lines_of(reports, seconds_each, least_s=10):
    """Lines of reports that come ``seconds_each`` after each other."""
    out, now = io.StringIO(), iter(range(10**6))
    show = ProgressLines(out, least_s, clock=lambda: seconds_each * next(now))
    for report in reports:
        show(*report)
    return out.getvalue().splitlines()


def test_a_short_task_is_one_line():
    assert lines_of([("judge", done, 18) for done in range(1, 19)], 0.1) == ["judge: 18/18"]


def test_a_long_task_has_a_line_each_tenth():
    lines = lines_of([("train", done, 1000, "loss 1") for done in range(1, 1001)], 2)
    assert lines == [f"train: {done}/1000 loss 1" for done in (5, *range(100, 1001, 100))]


def test_lines_are_ten_seconds_apart():
    lines = lines_of([("train", done, 20) for done in range(1, 21)], 4)
    assert lines == [f"train: {done}/20" for done in (3, 6, 9, 12, 15, 18, 20)]


def test_a_task_done_many_times_is_not_a_line_each_time():
    lines = lines_of([("judge", done, 5) for _ in range(60) for done in range(1, 6)], 0.1)
    assert 1 <= len(lines) <= 4


def test_times_are_whole_on_a_narrow_terminal():
    for width in (80, 100):
        out = io.StringIO()
        console = Console(file=out, width=width, force_terminal=True, color_system=None)
        with progress_bars(console) as progress:
            progress("standardise", 150, 1500, "scale_x 3.76 scale_y 1.87 scale_z 1.31 and a long note " * 2)
        last = [line for line in out.getvalue().splitlines() if "standardise" in line][-1]
        assert "150/1500 0:00:00 left -:--:-- scale_x" in last
        assert "…" in last.split("scale_x")[1]  # only the note is cut


def test_the_studio_reads_each_tenth_as_it_begins():
    lines = lines_of([("train", done, 40) for done in range(41)], 0.1, least_s=0)
    assert lines == [f"train: {done}/40" for done in range(0, 41, 4)]


def test_simulated_participants_are_lines_in_a_log(tmp_path, capsys):
    assert main(["study", "simulate", "abx", "--participants", "2", "--out", str(tmp_path / "s")]) == 0
    said = capsys.readouterr().err
    assert "\r" not in said
    assert said == "participants: 2/2\n"


def test_quiet_shows_no_progress(tmp_path, capsys):
    asked = ["study", "simulate", "abx", "--participants", "2", "--json", "--quiet"]
    assert main([*asked, "--out", str(tmp_path / "s")]) == 0
    quiet = capsys.readouterr()
    assert quiet.err == ""
    assert len(json.loads(quiet.out)) > 0
