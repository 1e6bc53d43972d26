"""A file for every condition of a table."""

import json

import pytest

from tactogram.cli import main
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal.io import read_signal
from tactogram.workflows.generation import many
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.generation.many import generate_many, read_conditions

TABLE = """material,mix,speed,seconds,seed,file
cork,,60,,,
,"cork=0.5,denim=0.5",120,0.5,7,mixed.wav
denim,,60,,3,
"""


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "conditions.csv"
    path.write_text(TABLE)
    return path


def test_every_row_is_generated_as_it_would_be_alone(table, tmp_path):
    written = generate_many("texture_flow", table, tmp_path / "out", seconds=0.25, processes=1)
    assert [file["file"] for file in written] == [
        str(tmp_path / "out" / name) for name in ("1.wav", "mixed.wav", "3.wav")
    ]
    [alone] = generate(
        "texture_flow", {"material": {"cork": 0.5, "denim": 0.5}, "speed_mm_s": 120.0}, seconds=0.5, seed=7
    )
    assert (read_signal(tmp_path / "out" / "mixed.wav").samples == alone.samples).all()
    assert json.loads((tmp_path / "out" / "generated.json").read_text()) == written
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == [
        "1.wav",
        "3.wav",
        "generated.json",
        "mixed.wav",
    ]


@pytest.fixture(params=["pickled", pytest.param("processes", marks=pytest.mark.slow)])
def elsewhere(request):
    """Run tasks for two processes: as those would be sent them, or in those."""
    return request.getfixturevalue("pickled_tasks") if request.param == "pickled" else [None]


def test_processes_change_nothing_and_a_killed_call_goes_on(table, tmp_path, monkeypatch, elsewhere):
    monkeypatch.setattr(many, "CHUNK", 1)
    here, there = tmp_path / "here", tmp_path / "there"
    generate_files = many.generate_files

    def killed(*args, **kwargs):
        if args[2].name == "3.wav":
            raise KeyboardInterrupt
        return generate_files(*args, **kwargs)

    monkeypatch.setattr(many, "generate_files", killed)
    with pytest.raises(KeyboardInterrupt):
        generate_many("texture_flow", table, here, seconds=0.25, processes=1)
    monkeypatch.setattr(many, "generate_files", generate_files)
    assert len(list((here / "made").iterdir())) == 2
    (here / "1.wav").write_bytes(b"is not made again")
    generate_many("texture_flow", table, here, seconds=0.25, processes=1)
    generate_many("texture_flow", table, there, seconds=0.25, processes=2)
    assert (here / "1.wav").read_bytes() == b"is not made again"
    assert elsewhere
    one, other = (read_signal(folder / "mixed.wav").samples for folder in (here, there))
    assert (one == other).all()


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ("no such material,,60,,,", "material must be one of"),
        (',"cork=nan",60,,,', "weight of cork must be finite"),
        ("cork,,60,-1,,", "seconds must be > 0"),
        ("cork,,60,,,b.xyz", "suffix must be one of"),
        (f"cork,,60,,,{'x' * 300}.wav", "a name must have at most 255 bytes"),
    ],
)
def test_nothing_is_written_if_a_later_row_is_wrong(table, tmp_path, row, says):
    table.write_text(f"{TABLE}{row}\n")
    with pytest.raises(TactogramError, match=says):
        generate_many("texture_flow", table, tmp_path / "out", seconds=0.25, processes=1)
    assert not (tmp_path / "out").exists()


def test_toml_has_the_same_rows(table, tmp_path):
    toml = tmp_path / "conditions.toml"
    toml.write_text(
        '[[condition]]\nmaterial = "cork"\nspeed = 60\n'
        "[[condition]]\nmix = { cork = 0.5, denim = 0.5 }\nspeed = 120\nseconds = 0.5\nseed = 7\n"
        'file = "mixed.wav"\n[[condition]]\nmaterial = "denim"\nspeed = 60\nseed = 3\n'
    )
    assert read_conditions(toml, suffix=".wav") == read_conditions(table, suffix=".wav")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("material\n", "must have a condition in each row"),
        ("material,colour\ncork,red\n", "row 2: unknown key 'colour'; known here: contactor, file, force"),
        ("material,speed\ncork,fast\n", "row 2: speed: must be a valid number"),
        ('material,mix\ncork,"cork=1"\n', "row 2: must have material or mix, got both"),
        ("file,material\na.wav,cork\na.wav,denim\n", "every row must have a file of its own"),
    ],
)
def test_a_wrong_table_is_refused_by_row(table, text, message):
    table.write_text(text)
    with pytest.raises((DataError, ParameterError), match=message):
        read_conditions(table, suffix=".wav")


def test_options_that_the_table_states_are_refused_beside_it(table, tmp_path, capsys):
    told = ["generate", "texture_flow", "--conditions", str(table), "--out", str(tmp_path / "out")]
    for wrong, message in (
        ([*told, "--material", "cork"], "omit --material"),
        (
            ["generate", "texture_flow", "--out", "x.wav", "--on", "ray"],
            "--on and --processes are for --conditions",
        ),
    ):
        assert main(wrong) == 2
        assert message in capsys.readouterr().err
    assert main([*told, "--seconds", "0.25", "--processes", "1", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["files"]) == 3


def test_a_table_says_which_files_are_limited(tmp_path, capsys):
    table = tmp_path / "conditions.csv"
    table.write_text("material,speed\ncork,60\ncork,600\n")
    made = generate_many("texture_flow", table, tmp_path / "out", seconds=0.25, processes=1)
    assert ["limited" in row for row in made] == [False, True]
    told = ["--conditions", str(table), "--seconds", "0.25", "--processes", "1", "--quiet"]
    assert main(["generate", "texture_flow", *told, "--out", str(tmp_path / "again")]) == 0
    [note] = capsys.readouterr().err.splitlines()
    assert note.startswith(f"note: {tmp_path / 'again' / '2.wav'}: speed 600 mm/s")
