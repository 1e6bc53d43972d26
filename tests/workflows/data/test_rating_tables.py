"""Putting tables of ratings into a store, and what is said of them."""

import json

import numpy as np
import pytest
import soundfile

from tactogram.cli import main
from tactogram.cli.printing import ratings_text
from tactogram.datasets import EVOKED, Ratings, Recording, create_store, open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.ratings.words import WORDS
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, MissingExtraError, ParameterError
from tactogram.signal import Signal
from tactogram.workflows.data.rating_tables import rate_store, ratings_info
from tactogram.workflows.data.stores import check_store, store_info


@pytest.fixture
def store(tmp_path):
    rng = np.random.default_rng(0)
    recordings = [
        Recording(streams={"strain": Signal(rng.standard_normal(20), 100.0, "V")}, material=f"plate{n:02d}")
        for n in range(1, 4)
    ]
    create_store(tmp_path / "s", recordings, name="plates", licence="CC0-1.0")
    return tmp_path / "s"


def wide(path, items, *, raters=("r1", "r2", "r3"), head="rater,item"):
    rng = np.random.default_rng(len(items))
    rows = [[rater, item, *rng.integers(1, 8, 10).astype(str)] for rater in raters for item in items]
    path.write_text("\n".join([head + "," + ",".join(WORDS), *(",".join(row) for row in rows)]) + "\n")
    return path


def test_a_table_is_put_in(store, tmp_path):
    table = wide(tmp_path / "r.csv", ["plate01", "plate02"])
    table.write_text(table.read_text() + "r4,plate01" + "," * 9 + ",3\n")
    facts = rate_store(store, [table])
    assert (facts["items"], facts["raters"], facts["scores"]) == (2, 4, 61)
    assert facts["blank"] == {"r4": 9}
    assert facts["unrated"] == ["plate03"]
    assert not facts["replaced"]
    rated = open_store(store)
    assert facts["sha256"] == rated.sha256
    assert rated.ratings.words == WORDS
    assert check_store(store)["ok"]


@pytest.mark.parametrize("more", [[], ["--wide"]])
def test_ratings_come_out_as_a_table_that_goes_in_again(store, tmp_path, capsys, more):
    rate_store(store, [wide(tmp_path / "r.csv", ["plate01", "plate03"])])
    before = open_store(store).ratings
    assert main(["data", "ratings", str(store), "--out", str(tmp_path / "out.csv"), "--json", *more]) == 0
    assert json.loads(capsys.readouterr().out)["scores"] == len(before) == 60
    assert len((tmp_path / "out.csv").read_text().splitlines()) == (7 if more else 61)
    rate_store(store, [tmp_path / "out.csv"], replace=True)
    np.testing.assert_array_equal(open_store(store).ratings.cube, before.cube)


def test_ratings_of_a_store_without_any_are_not_written(store, tmp_path, capsys):
    assert main(["data", "ratings", str(store), "--out", str(tmp_path / "out.csv")]) == 1
    assert "has no ratings; add a table of them (`data rate`)" in capsys.readouterr().err
    assert not (tmp_path / "out.csv").exists()


def test_headings_and_items_are_mapped(store, tmp_path):
    table = wide(tmp_path / "r.csv", ["1", "3"], head="Subject,Sample No.")
    settings = {"column.rater": "Subject", "column.item": "Sample No.", "item": "plate{:0>2}"}
    rate_store(store, [table], options=settings)
    assert open_store(store).ratings.items == ("plate01", "plate03")


def test_two_tables_become_one(store, tmp_path):
    tables = [wide(tmp_path / "a.csv", ["plate01"]), wide(tmp_path / "b.csv", ["plate02"], raters=("q",))]
    facts = rate_store(store, tables)
    assert (facts["items"], facts["raters"], facts["scores"]) == (2, 4, 40)


def test_earlier_ratings_go_only_when_it_is_said(store, tmp_path):
    table = wide(tmp_path / "r.csv", ["plate01"])
    first = rate_store(store, [table])
    with pytest.raises(DataError, match="`replace`"):
        rate_store(store, [wide(tmp_path / "q.csv", ["plate02", "plate03"])])
    assert open_store(store).sha256 == first["sha256"]
    again = rate_store(store, [tmp_path / "q.csv"], replace=True)
    assert again["replaced"]
    assert open_store(store).ratings.items == ("plate02", "plate03")
    assert problems(open_store(store)) == []


@pytest.mark.parametrize(
    ("text", "options", "says"),
    [
        ("rater,item,word,score\nr,plate09,dry,1\n", {}, "items in the store, got plate09"),
        ("rater,item,word,score\nr,plate01,dry,1\n", {"scale": "nine"}, "a scale must be 7-point"),
        ("rater,item,word,score\nr,plate01,dry,0\n", {}, "row 2 .*must be 1 to 7"),
        ("rater,item,word,score\nr,plate01,dry,1\n", {"options": {"colum.rater": "x"}}, "got 'colum.rater'"),
        ("rater,item,word,score\nr,plate01,dry,1\n", {"options": {"column.who": "x"}}, "got 'who'"),
        ("rater,item,word,score\nr,1,dry,1\n", {"options": {"item": "a{},b{}"}}, "each of 1 files, got 2"),
    ],
)
def test_what_is_refused_leaves_the_store_as_it_was(store, tmp_path, text, options, says):
    (tmp_path / "r.csv").write_text(text)
    before = {path.name: path.read_bytes() for path in store.iterdir()}
    with pytest.raises((DataError, ParameterError), match=says):
        rate_store(store, [tmp_path / "r.csv"], **options)
    assert {path.name: path.read_bytes() for path in store.iterdir()} == before


def test_info_counts_what_is_missing_of_whom():
    rows = [("a", "p", "dry"), ("a", "p", "rough"), ("b", "p", "dry"), ("b", "q", "rough"), ("b", "q", "dry")]
    rater, item, word = zip(*rows, strict=True)
    facts = ratings_info(Ratings(rater, item, word, np.array([1, 2, 3, 4, 5.0])))
    assert facts["missing"] == {"blank": 1, "blank_by_rater": {"b": 1}, "not_met": 1}
    assert (facts["scores"], facts["items"], facts["raters"]) == (5, 2, 2)
    assert facts["reliability"]["words"]["dry"]["mean"] == 3
    json.dumps(facts, allow_nan=False)


def test_reliability_is_told_word_by_word():
    rng = np.random.default_rng(0)
    items, raters = 12, 8
    agreed = np.repeat(rng.integers(1, 8, items)[:, None], raters, 1)
    scores = np.stack([agreed, rng.integers(1, 8, (items, raters))], 2).astype(float)
    places = [(i, r, w) for i in range(items) for r in range(raters) for w in range(2)]
    facts = ratings_info(
        Ratings(
            tuple(f"r{r}" for _, r, _ in places),
            tuple(f"p{i}" for i, _, _ in places),
            tuple(("dry", "rough")[w] for _, _, w in places),
            np.array([scores[place] for place in places]),
        )
    )
    dry, rough = facts["reliability"]["words"]["dry"], facts["reliability"]["words"]["rough"]
    assert facts["reliability"]["level"] == "ordinal"
    assert dry["alpha"] == 1
    assert dry["icc_single"] == pytest.approx(1)
    assert abs(rough["alpha"]) < 0.2
    assert (rough["icc_items"], rough["icc_raters"]) == (12, 8)


def test_yes_and_no_are_nominal_and_means_of_one_rater_have_no_reliability():
    ratings = Ratings(("r",) * 2, ("p", "q"), ("dry",) * 2, np.array([0.0, 1.0]), EVOKED)
    facts = ratings_info(ratings)
    assert facts["reliability"]["level"] == "nominal"
    assert facts["reliability"]["words"]["dry"]["alpha"] is None


def test_the_command_rates_and_tells(store, tmp_path, capsys):
    wide(tmp_path / "r.csv", ["plate01", "plate02", "plate03"])
    assert main(["data", "rate", str(store), str(tmp_path / "r.csv"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["scores"] == 90
    assert main(["data", "info", str(store)]) == 0
    text = capsys.readouterr().out
    assert "ratings: 90 scores of 3 items by 3 raters, 7-point unipolar (1 to 7)" in text
    assert "missing: 0 left blank; 0 of 9 pairs of rater and item without any score" in text
    assert "rustle" in text
    assert main(["data", "rate", str(store), str(tmp_path / "r.csv")]) == 1
    assert "--replace" in capsys.readouterr().err
    assert store_info(store)["ratings"]["scores"] == 90


def test_exports_of_a_questionnaire_go_in_as_they_are_and_what_is_left_out_is_said(store, tmp_path, capsys):
    for person in ("p1", "p2"):
        (tmp_path / f"{person}.csv").write_text(
            "item,rough.response,rough.rt,participant,psychopyVersion,\n"
            f",,,{person},2025.1.1,\nplate01,6,1.2,{person},2025.1.1,\nplate02,3,0.8,{person},2025.1.1,\n"
        )
    files = [str(tmp_path / f"{person}.csv") for person in ("p1", "p2")]
    assert main(["data", "rate", str(store), *files]) == 0
    assert capsys.readouterr().out.splitlines()[-4:] == [
        "2 files: read as an export of PsychoPy: rater of 'participant', item of 'item'",
        "2 files: columns left out, as they have no heading: 6",
        "2 files: rows left out without an answer: 1, the first is row 2",
        "2 files: columns left out: rough.rt, psychopyVersion",
    ]
    np.testing.assert_array_equal(open_store(store).ratings.cube, [[[6], [6]], [[3], [3]]])
    (tmp_path / "p1.csv").write_text(
        "item,slider.response,participant,psychopyVersion\nplate01,6,p1,2025.1.1\n"
    )
    asked = ["data", "rate", str(store), files[0], "--replace"]
    assert main(asked) == 1
    assert "column.WORD=HEADING" in capsys.readouterr().err
    assert main([*asked, "--set", "column.rough=slider.response"]) == 0
    assert len(open_store(store).ratings) == 1


def test_a_study_of_ones_own_files_comes_in(tmp_path):
    """What docs/ratings.md shows: plates that were measured, signals that were displayed, two tables."""
    rng = np.random.default_rng(0)
    lines = ["file,stream,unit,axes,session,speed_mm_s,force_n"]
    for name, stream in [("plate01/m01", "strain"), ("plate01/m02", "strain"), ("signals/signal01", "drive")]:
        path = tmp_path / "study" / f"{name}.wav"
        path.parent.mkdir(parents=True, exist_ok=True)
        samples = rng.uniform(-0.5, 0.5, (100, 4 if stream == "strain" else 1))
        soundfile.write(path, samples, 10_000, subtype="FLOAT")
        about = f"V,g1 g2 g3 g4,{name.replace('/', '-')},20,0.98" if stream == "strain" else "1,drive,,,"
        lines.append(f"{name}.wav,{stream},{about}")
    (tmp_path / "study" / "recordings.csv").write_text("\n".join(lines) + "\n")
    import_dataset("folder", tmp_path / "study", tmp_path / "s", options={"items": "signals"})
    tables = [wide(tmp_path / "plates.csv", ["1"]), wide(tmp_path / "signals.csv", ["1"])]
    facts = rate_store(tmp_path / "s", tables, options={"item": "plate{:0>2},signal{:0>2}"})
    assert facts["unrated"] == []
    store = open_store(tmp_path / "s")
    assert {info.material: store.streams_of(info.id) for info in store.index} == {
        "plate01": ("strain",),
        None: ("drive",),
    }
    assert store.streams["strain"].axes == ("g1", "g2", "g3", "g4")
    assert store.ratings.items == ("plate01", "signal01")


def test_without_the_library_of_alpha_the_rest_is_told_and_what_to_install(store, tmp_path, monkeypatch):
    def missing(*_, **__):
        raise MissingExtraError("nltk is needed for Krippendorff's alpha; install the extra statistics")

    monkeypatch.setattr("tactogram.statistics.reliability.imported", missing)
    rate_store(store, [wide(tmp_path / "t.csv", ["plate01", "plate02", "plate03"])])
    found = ratings_info(open_store(store).ratings)
    assert "install the extra statistics" in found["reliability"]["alpha_missing"]
    assert {known["alpha"] for known in found["reliability"]["words"].values()} == {None}
    assert "no alpha: nltk is needed" in ratings_text(found)
