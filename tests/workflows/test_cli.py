import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from tactogram.cli import main
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.workflows import doctor


def test_help_names_every_verb(capsys):
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    for verb in (
        "demo",
        "doctor",
        "data",
        "models",
        "train",
        "crossval",
        "evaluate",
        "generate",
        "classify",
        "search",
    ):
        assert f"\n  {verb} " in said


@pytest.mark.parametrize(
    "arguments", [["nothing"], ["train"], ["train", "stroke_cnn"], ["generate", "r", "--mix", "a=1"]]
)
def test_a_usage_error_exits_2(arguments, capsys):
    try:
        status = main(arguments)
    except SystemExit as stopped:
        status = stopped.code
    assert status == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["train", "nothing", "--data", "STORE"],
            "model must be one of ar_texture, frictgan, nearest_photo, pix2pix",
        ),
        (["train", "nothing", "--data", "STORE"], "or of a folder in --models, got 'nothing'"),
        (
            ["train", "stroke_cnn", "--data", "STORE", "--recipe", "x"],
            "recipe of stroke_cnn must be one of paper",
        ),
        (["train", "stroke_cnn", "--data", "STORE", "--set", "config.step=1"], "unknown key 'step'"),
        (
            ["evaluate", "RUN", "--evaluation", "step=1"],
            "--evaluation: unknown key 'step'; known here: longest_s",
        ),
        (
            ["evaluate", "RUN", "--evaluation", "steps=0"],
            "--evaluation: steps: must be greater than 0, got 0",
        ),
        (["train", "stroke_cnn", "--data", "STORE", "--band", "20", "1000"], "165"),
        (["train", "stroke_cnn", "--data", "nowhere"], "nowhere"),
        (["evaluate", "nowhere"], "nowhere: not a run"),
        (["crossval", "stroke_cnn", "--data", "STORE", "--split", "last=x"], "--split last=N needs a number"),
        (
            ["crossval", "stroke_cnn", "--data", "STORE", "--folds", "1"],
            "--folds must be greater than or equal to 2",
        ),
        (["classify", "RUN", "nowhere.wav"], "nowhere.wav"),
        (["reproduce", "nothing"], "experiment must be one of"),
        (
            ["train", "stroke_cnn", "--data", "STORE", "--set", "steps=1"],
            "a setting of the model is config.NAME",
        ),
        (["train", "stroke_cnn", "--data", "RUN"], "is not a store: it is a run"),
        (["data", "info", "nowhere"], "not a store: no such folder; make one: tactogram data import folder"),
        (
            ["data", "info", "."],
            "make one of the recordings in it: tactogram data import folder . --out STORE",
        ),
        (
            ["evaluate", "STORE"],
            "not a run: it is a store; train a model on it: tactogram train MODEL --data",
        ),
        (
            ["generate", "RUN", "--out", "x.wav"],
            "stroke_cnn does not generate, it is a model for classification",
        ),
        (["generate", "texture_flow", "--out", "x.wav"], "tactogram generate texture_flow --material "),
        (["table", "RUN"], "was not evaluated: tactogram evaluate "),
        (["table", "--model", "nothing"], "no row contains all of that; `tactogram table` lists every row"),
        (["reproduce", "tactile_image_cgan_figure4", "--data", "x"], "takes no --data; its options: images"),
    ],
)
def test_what_is_wrong_is_one_line(arguments, message, store, run, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    places = {"STORE": str(store), "RUN": str(run.folder)}
    assert main([places.get(a, a) for a in arguments]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    last = said.err.strip().split("\n")[-1]
    assert last.startswith("tactogram: ")
    assert message in last
    assert "Traceback" not in said.err


def test_results_are_one_json_object(run, capsys, tmp_path, texture):
    file = tmp_path / "x.wav"
    write_signal(file, texture("tile", 8))
    assert main(["classify", str(run.folder), str(file), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["files"][str(file)]
    assert said["material"] == "tile"
    assert main(["search", str(run.folder), str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nearest"][0]["material"] == "tile"
    assert main(["evaluate", str(run.folder), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert {"window_accuracy", "recording_accuracy"} <= figures.keys()


def test_the_same_without_json_is_for_people(run, capsys):
    for arguments in (
        ["models"],
        ["doctor"],
        ["table"],
        ["reproduce", "--list"],
        ["evaluate", str(run.folder)],
    ):
        assert main(arguments) == 0
        assert capsys.readouterr().out.strip()


def test_a_model_is_shown_with_the_settings_of_a_training(capsys):
    assert main(["models", "stroke_cnn", "--recipe", "paper", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["settings"]["config.window"]["value"] == 200
    assert main(["models", "stroke_cnn"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "recipes: paper, quick, tiny" in lines
    assert any(line.split()[:2] == ["config.dropout", "0.5"] for line in lines)
    assert main(["models", "stroke_cn"]) == 1
    assert capsys.readouterr().err.endswith("did you mean 'stroke_cnn'?\n")


def test_the_table_is_filtered_and_fits_a_terminal(capsys, monkeypatch):
    assert main(["table", "--model", "cnn", "--figure", "CLASSIFIED", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert rows
    assert all(row["model"] == "stroke_cnn" and "classified" in row["what"] for row in rows)
    monkeypatch.setattr("tactogram_benchmark.cli.benchmarking.terminal_width", lambda: 100)
    assert main(["table"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 100
    assert any("…" in line for line in lines)


def test_an_evaluated_run_is_listed_first_in_the_table(run, capsys):
    assert main(["evaluate", str(run.folder), "--json"]) == 0
    measured = json.loads(capsys.readouterr().out)
    assert main(["table", str(run.folder), "--figure", "recording_accuracy", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["rows"][0]
    assert (first["model"], first["ours"]) == ("stroke_cnn", measured["recording_accuracy"])
    assert first["data"] == "textures (simulated)"


def test_predictions_have_headings(run, texture, tmp_path, capsys):
    write_signal(tmp_path / "x.wav", texture("tile", 8))
    assert main(["classify", str(run.folder), str(tmp_path / "x.wav")]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["file", "material", "probability"]
    assert row.split()[1] == "tile"


def test_doctor_tells_versions_and_extras(capsys):
    assert main(["doctor", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["packages"]["torch"].startswith("2.")
    assert facts["extras"]["dev"] == {"for": "tests, style, types, benchmarks", "missing": []}
    assert "LPIPS" in facts["extras"]["vision"]["for"]
    assert facts["device"]


def test_doctor_tells_which_weights_are_missing_and_where_they_are_from(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    (tmp_path / "checkpoints").mkdir()
    (tmp_path / "checkpoints" / "vgg19-dcbb9e9d.pth").write_bytes(b"other bytes")
    assert main(["doctor"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("weights of")]
    assert len(lines) == 4
    assert (
        f"AlexNet (LPIPS): missing: {tmp_path}/checkpoints/alexnet-owt-7be5be79.pth, SHA-256 7be5be79"
        in lines[0]
    )
    assert "https://github.com/toshas/torch-fidelity" in lines[1]
    assert "another checksum" in lines[2]


@pytest.mark.parametrize("compiled", [True, False])
def test_doctor_tells_whether_torchvision_has_its_compiled_operators(compiled, monkeypatch):
    extension = SimpleNamespace(_has_ops=lambda: compiled)
    monkeypatch.setattr("tactogram.nn.vision_import.vision_module", lambda name: extension)
    monkeypatch.setattr(doctor, "find_spec", lambda name: name == "torchvision" or None)
    said = [problem for problem in doctor.doctor()["problems"] if "torchvision" in problem]
    assert [("tactogram does without them" in problem) for problem in said] == [True] * (not compiled)


def test_the_command_starts_as_a_program():
    done = subprocess.run(
        [sys.executable, "-m", "tactogram", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("tactogram 0.")


def test_a_table_is_converted_by_its_columns(tmp_path, capsys):
    rows = "\n".join(f"{k / 100},{k % 7},{k % 5}" for k in range(200))
    (tmp_path / "t.csv").write_text(f"clock,ax,ay\n{rows}\n")
    options = [
        "--time",
        "clock",
        "--axes",
        "ay",
        "--unit",
        "m/s^2",
        "--resample",
        "50",
        "--subtype",
        "PCM_16",
    ]
    assert main(["convert", str(tmp_path / "t.csv"), str(tmp_path / "t.wav"), *options, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["rate_hz"], facts["unit"], facts["axes"], facts["samples"]) == (50.0, "m/s^2", ["y"], 100)


def test_a_signal_over_displacement_is_played_at_a_speed(tmp_path, capsys):
    ridges = Signal(
        np.sin(2 * np.pi * 2 * np.arange(400) / 10)[None], 10.0, "1", ("friction",), "displacement"
    )
    write_signal(tmp_path / "x.npz", ridges)
    for speed in (25.0, 50.0, 100.0):
        argv = [
            "convert",
            str(tmp_path / "x.npz"),
            str(tmp_path / "y.npz"),
            "--play-at",
            f"{speed:g}",
            "--resample",
        ]
        assert main([*argv, "2000", "--json"]) == 0
        facts = json.loads(capsys.readouterr().out)
        assert (facts["rate_hz"], facts["samples"]) == (2000.0, round(40 / speed * 2000))
        x = read_signal(tmp_path / "y.npz").samples[0]
        peak = np.argmax(np.abs(np.fft.rfft(x * np.hanning(len(x))))) * 2000 / len(x)
        assert peak == pytest.approx(2 * speed, abs=speed / 40)


def test_a_model_from_another_folder_is_found_by_every_verb(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("TACTOGRAM_MODELS", "")
    folder = tmp_path / "mine" / "my_model"
    folder.mkdir(parents=True)
    facts = 'title = "Mine"\nauthors = ["Me"]\nyear = 2026\n'
    facts += 'task = "generation"\nneeds = ["material"]\ngives = "signal"\n'
    (folder / "model.toml").write_text(facts)
    assert main(["models", "--models", str(tmp_path / "mine"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["my_model"]["title"] == "Mine"


def test_a_check_says_what_to_type(tmp_path, capsys):
    rows = "".join(f"{t},{t % 3}\n" for t in [*range(50), *range(300, 350)])
    (tmp_path / "t.csv").write_text(f"t [ms],x [g]\n{rows}")
    assert main(["convert", "--check", str(tmp_path / "t.csv")]) == 1
    assert "choose one of the 2 parts between, e.g. the longest, `--part 1`" in capsys.readouterr().out
