"""Verbs on data: what an import advises can be typed, and helps."""

import re
import shlex

import numpy as np
import pytest

from tactogram.cli import main

ROWS = range(90)
TABLES = {
    "no time": ("cork/a.csv", "x,y\n" + "1,2\n" * 90),
    "no folder": ("cork.csv", "t [s],x [g]\n" + "".join(f"{k / 100},{k % 7}\n" for k in ROWS)),
}
MAPPED = {
    "a word": ("t [s],x [g]\n0,1\n0.1,one\n0.2,2\n", "x [g]"),
    "no labels": ("t [s],x [g],label\n" + "".join(f"{k / 100},1,n{k}\n" for k in ROWS), "label"),
}


def write(folder, name, text):
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text)
    return ["data", "import", "folder", str(folder)]


@pytest.mark.parametrize("case", TABLES)
def test_what_a_skipped_file_advises_reads_it(tmp_path, capsys, case):
    words = [*write(tmp_path / "f", *TABLES[case]), "--preview"]
    assert main(words) == 1
    [line] = [
        line for line in capsys.readouterr().out.splitlines() if line.startswith(("skipped: ", "to answer: "))
    ]
    advised = re.search("`(--set [^`]+)`", line)[1]
    assert main([*words, *shlex.split(advised)]) == 0


@pytest.mark.parametrize("case", MAPPED)
def test_the_advised_mapping_is_written_and_names_the_column(tmp_path, capsys, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    text, column = MAPPED[case]
    words = write(tmp_path / "f", "cork/a.csv", text)
    assert main([*words, "--out", "s"]) == 1
    advised = re.search("`(--preview [^`]+)`", capsys.readouterr().err)[1]
    assert main([*words, *shlex.split(advised)]) == 1
    assert f'"{column}"' in (tmp_path / "mapping.toml").read_text()


def test_a_rate_that_contradicts_a_file_is_omitted(tmp_path, capsys):
    words = write(tmp_path / "f", *TABLES["no time"])
    np.savez(tmp_path / "f" / "cork" / "b.npz", x=np.sin(np.arange(90)), rate=500.0)
    main([*words, "--preview", "--set", "rate=1000"])
    assert (
        "expected 1000; resample afterwards, here omit --set rate=…, or state it in recordings.csv"
        in capsys.readouterr().out
    )
