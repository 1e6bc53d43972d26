"""Verbs of several workflows: training resumed, motions followed."""

import numpy as np

from tactogram.cli import main
from tactogram.signal.io import read_metadata, read_signal


def test_what_a_run_has_said_is_not_said_again(run, capsys):
    assert (
        main(["train", "--resume", str(run.folder), "stroke_cnn", "--split", "all", "--set", "seed=1"]) == 2
    )
    assert "omit MODEL, --set, --split" in capsys.readouterr().err


def test_a_finished_run_is_given_as_it_is(run, capsys):
    assert main(["train", "--resume", str(run.folder)]) == 0
    assert f"run: {run.folder}" in capsys.readouterr().out


def test_a_training_needs_a_model_and_data(capsys):
    assert main(["train", "stroke_cnn"]) == 2
    assert "needs --data DIR and MODEL or --for, or --resume RUN" in capsys.readouterr().err


def test_a_recorded_motion_is_followed_and_named_in_the_file(tmp_path, capsys):
    motion, out = tmp_path / "hand.csv", tmp_path / "felt.wav"
    motion.write_text(
        "time_s,speed_mm_s,force_n\n0,60,0.5\n1,60,0.5\n1.2,300,1\n2.4,300,1\n2.5,300,0\n3,0,0\n"
    )
    told = ["generate", "texture_flow", "--material", "corduroy", "--motion", str(motion), "--out", str(out)]
    assert main(told) == 0
    samples, rate = read_signal(out).samples[0], 2500
    assert len(samples) == 3 * rate
    slow, fast = samples[rate // 5 : rate].std(), samples[round(1.4 * rate) : round(2.3 * rate)].std()
    assert fast > 3 * slow > 0
    assert np.ptp(samples[round(2.7 * rate) :]) == 0
    assert read_metadata(out)["motion_from"] == "hand.csv"
    assert main([*told, "--force", "1"]) == 1
    assert "the motion has its own force_n; omit it" in capsys.readouterr().err
