"""Metadata in paths: patterns, what a preview proposes, and what an import asks before people become materials."""

import itertools
import json
import re
import shlex

import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.path_reading import PathPattern, read_paths
from tactogram.errors import ParameterError


@pytest.mark.parametrize(
    ("pattern", "path", "fields"),
    [
        (
            "{subject}/{material}/{speed}mms/take{take}",
            "own/P01/cork/40mms/take1.csv",
            {"subject": "P01", "material": "cork", "speed_mm_s": 40, "trial": "1"},
        ),
        ("{material}/{speed}/*", "cork/40mm_s/a.csv", {"material": "cork", "speed_mm_s": 40}),
        ("{material}/{speed}/*", "cork/4cms/a.csv", {"material": "cork", "speed_mm_s": 40}),
        ("{material}/{speed}/{}", "cork/0.04ms/a.csv", {"material": "cork", "speed_mm_s": 40}),
        ("{material}/{speed}cms/{_}", "cork/4cms/a.csv", {"material": "cork", "speed_mm_s": 40}),
        ("{material}/{speed}", "cork/40.csv", {"material": "cork", "speed_mm_s": 40}),
        (
            "{material}_F{}_V{speed}_{take}",
            "cork_F120_V-40mmps_0.csv",
            {"material": "cork", "speed_mm_s": 40, "way": "back", "trial": "0"},
        ),
        ("{material}/{force}/*", "cork/500mN/a.csv", {"material": "cork", "force_n": 0.5}),
        ("{material}/{force}N/*", "cork/0p5N/a.csv", {"material": "cork", "force_n": 0.5}),
        ("{material}/{force}/*", "cork/50g/a.csv", {"material": "cork", "force_n": 0.4903325}),
        ("{material}/{direction}/*", "cork/135deg/a.csv", {"material": "cork", "direction_deg": 135}),
        ("{material}/{direction}/*", "cork/left/a.csv", {"material": "cork", "direction": "left"}),
        (
            "{material}_{contactor}_{trial}",
            "x/sand_paper_pen_1.wav",
            {"material": "sand_paper", "contactor": "pen", "trial": "1"},
        ),
        ("{material}{take}", "sand_paper12.csv", {"material": "sand_paper", "trial": "12"}),
        (
            "{material}-{session}",
            "cork-2026-01-02_10-23-45.csv",
            {"material": "cork", "session": "2026-01-02_10-23-45"},
        ),
        ("{MATERIAL}/{take}.csv", "cork/1.csv", {"MATERIAL": "cork", "trial": "1"}),
        ("TAKE{take}/{hand}", "take3/R.csv", {"trial": "3", "hand": "R"}),
        ("{material}_{take}", "cork 3.csv", {"material": "cork", "trial": "3"}),
        ("{material}/**", "a/b/c/d.csv", {"material": "a"}),
        ("{material}/{speed}", "cork/fast.csv", None),
        ("{subject}/{material}/{take}", "cork/1.csv", None),
    ],
)
def test_a_pattern_names_what_folders_and_names_hold(pattern, path, fields):
    found = PathPattern(pattern).fields(path)
    labels = found.pop("labels") if found else {}
    assert (None if found is None else found | labels) == fields


@pytest.mark.parametrize("pattern", ["cork", "{material}/{material}", "{material", "{a b}/{material}"])
def test_a_pattern_that_is_none_is_refused(pattern):
    with pytest.raises(ParameterError, match="path must be a pattern such as"):
        PathPattern(pattern)


def product(*levels):
    return ["/".join(names) for names in itertools.product(*levels)]


@pytest.mark.parametrize(
    ("takes", "proposed", "asked"),
    [
        (
            product(["P01", "P02"], ["cork", "tin"], ["40mms", "80mms"], ["take1", "take2"]),
            "{subject}/{material}/{speed}/take{take}",
            "2 materials, named like people: P01, P02",
        ),
        (product(["sub-01", "sub-02"], ["cork", "tin"]), "{subject}/{material}", "like people"),
        (product(["P01"], ["cork", "tin"], ["1", "2"]), "{subject}/{material}/{take}", "1 material, named"),
        (product(["P01", "P02"], ["take1", "take2"]), "", "named like people"),
        (product(["P80", "P120"], ["take1", "take2"]), "{material}/take{take}", ""),  # grits
        (product(["P80", "P120"], ["smooth", "worn"], ["1", "2"]), "{subject}/{material}/{take}", "people"),
        (product(["P80", "P120", "sandpaper"], ["1", "2"]), "{material}/{take}", ""),
        (product(["40mms", "80mms"], ["cork_1", "tin_1"]), "{speed}/{material}_{take}", "named like speeds"),
        (product(["1N", "2N"], ["cork", "tin"], ["a", "b"]), "{force}/{material}/{}", "named like forces"),
        (product(["2026-01-02_10-23-45", "2026-01-03_09-10-11"], ["x"]), "", "named like takes"),
        (product(["rec_001", "rec_002"], ["x"]), "", "named like takes"),
        (product(["1", "2", "3"], ["1", "2"]), "{material}/{take}", ""),  # materials by number
        (product(["01", "02"], ["cork", "tin"], ["1", "2"]), "{session}/{material}/{take}", "like takes"),
        (product(["Train", "Test"], ["cork", "tin"], ["1"]), "{part}/{material}/{take}", "parts of a split"),
        (product(["raw_data"], ["cork", "tin"], ["1", "2"]), "{material}/{take}", "1 material, named like"),
        (product(["own"], ["cork", "tin"], ["1", "2"]), "{material}/{take}", "names below it differ"),
        (product(["finger", "pen"], ["cork", "tin"], ["1"]), "{contactor}/{material}/{take}", "touches them"),
        (product(["cork", "tin"], ["slow", "fast"], ["1", "2"]), "{material}/{pace}/{take}", ""),
        (product(["cork"], ["day1", "day2"], ["1", "2"]), "{material}/day{session}/{take}", ""),
        (product(["cork"], ["good", "b"]), "", ""),
        (product(["Anna", "Ben"], ["cork", "tin"], ["1", "2"]), "", "both may be the materials"),
        (
            product(["Anna", "Ben"], ["cork_1", "tin_1"]),
            "",
            "path={subject}/{material}_{take}`, or `path={material}/",
        ),
        (product(["cork", "tin"], ["log", "lab"]), "", ""),
        (["cork 2026-01-02 10-11-12", "tin 2026-01-02 10-12-13"], "{material}_{take}", "named with dates"),
        (["cork/2", "cork/10", "jeans/day1/a"], "", ""),
        (["cork_1", "cork_2", "sand_paper_1"], "{material}_{take}", "no folder names the material"),
        (["P1_cork_4cms_1", "P2_tin_4cms_1"], "{subject}_{material}_{speed}_{take}", "no folder names"),
    ],
)
def test_what_varies_in_the_paths_is_proposed_and_doubtful_materials_are_asked_about(takes, proposed, asked):
    materials = [name.partition("/")[0] for name in takes if "/" in name or "-" in name]
    reading = read_paths(takes, materials)
    assert (reading.proposed, asked in reading.question) == (proposed, True)
    assert bool(asked) == bool(reading.question)
    if proposed:
        assert all(PathPattern(proposed).fields(name) for name in takes)


def write(folder, names):
    for number, name in enumerate(names):
        path = folder / f"{name}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = "".join(f"{k / 100},{(k + 3 * number) % (7 + number)}\n" for k in range(90))
        path.write_text("t [s],x [g]\n" + rows)
    return ["data", "import", "folder", str(folder)]


@pytest.mark.parametrize(
    ("takes", "proposed"),
    [
        (["cork_F120_V50mmps_0", "tin_F150_V-50mmps_1"], "{material}_{}_V{speed}_{take}"),
        (["cork_v-50mms_0", "tin_v-100mms_1"], "{material}_{}-{speed}_{take}"),
        (["cork_50mms_1", "fine-sandpaper_100mms_1"], "{material}_{speed}_{take}"),
    ],
)
def test_a_hyphen_may_be_a_sign_or_part_of_a_name(takes, proposed):
    """A speed or a force in the name of a material would make a class of each."""
    assert read_paths(takes, ()).proposed == proposed
    assert PathPattern(proposed).fields(takes[0])["material"] == "cork"


@pytest.mark.parametrize("answer", [0, 1])
def test_people_are_not_imported_as_materials_and_what_is_advised_can_be_typed(tmp_path, capsys, answer):
    words = write(tmp_path / "own", product(["P01", "P02"], ["cork", "tin"], ["40mms", "80mms"], ["take1"]))
    assert main([*words, "--out", str(tmp_path / "s")]) == 1
    said = capsys.readouterr().err
    assert "2 materials, named like people: P01, P02" in said
    assert not (tmp_path / "s").exists()
    advised = re.findall("`[^`]+ (--set path=[^`]+)`", said)[answer]
    assert main([*words, "--out", str(tmp_path / "s"), *shlex.split(advised)]) == 0
    index = open_store(tmp_path / "s").index
    first = (index[0].subject, index[0].material, index[0].speed_mm_s, index[0].labels)
    assert first == (("P01", "cork", 40.0, {"trial": "1"}) if answer == 0 else (None, "P01", None, {}))


def test_a_preview_proposes_and_asks_in_text_and_json(tmp_path, capsys):
    words = [*write(tmp_path / "own", product(["P1", "P7"], ["cork", "tin"])), "--preview"]
    assert main(words) == 1
    assert "to answer: " in capsys.readouterr().out
    assert main([*words, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["proposed_path"] == "{subject}/{material}"
    words = [*write(tmp_path / "more", product(["cork", "tin"], ["1", "2"])), "--preview"]
    assert main(words) == 0
    assert "--set path={material}/{take}\n" in capsys.readouterr().out


def test_a_file_that_a_pattern_does_not_describe_is_named(tmp_path, capsys):
    words = write(tmp_path / "own", ["cork/40mms", "cork/fast"])
    assert main([*words, "--out", str(tmp_path / "s"), "--set", "path={material}/{speed}"]) == 1
    assert "cork/fast.csv: must be named as path={material}/{speed} says" in capsys.readouterr().err


def test_labels_in_tables_and_recordings_csv_answer_the_question(tmp_path, capsys):
    words = write(tmp_path / "own", product(["P01", "P02"], ["a"]))
    (tmp_path / "own" / "recordings.csv").write_text("file,material\nP01/a.csv,cork\nP02/a.csv,tin\n")
    assert main([*words, "--out", str(tmp_path / "s")]) == 0
    (tmp_path / "own" / "recordings.csv").unlink()
    for name in ("P01", "P02"):
        rows = "".join(f"{k / 100},{k % 7},{'cork' if k < 50 else 'tin'}\n" for k in range(99))
        (tmp_path / "own" / name / "a.csv").write_text("t [s],x [g],material\n" + rows)
    assert main([*words, "--preview"]) == 0
    assert "cork 2, tin 2" in capsys.readouterr().out
