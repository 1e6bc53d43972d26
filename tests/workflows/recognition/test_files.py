"""Files that are scored and classified."""

from made_up_ratings import RATE, vibration

from tactogram.cli import main
from tactogram.signal import Signal
from tactogram.signal.io import write_signal


def test_what_a_rater_cannot_score_is_named_with_its_file(rater_run, tmp_path, capsys):
    good, other = tmp_path / "good.npz", tmp_path / "other.npz"
    write_signal(good, vibration(0.1, 5))
    write_signal(other, Signal(vibration(0.1, 5).samples, RATE, "V", ("g1",)))
    assert main(["score", str(rater_run), str(good), str(other)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(
        f"tactogram: {other}: signal must be 400 Hz, 1, axes drive; got 400 Hz, V, axes g1"
    )
    assert said.err.count("\n") == 1
