"""What a table of ratings promises, in memory, in a store and to learners."""

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given, strategies as st

from tactogram.datasets import (
    EVOKED,
    SEVEN_POINT,
    Examples,
    Ratings,
    Recording,
    Scale,
    Segment,
    add_ratings,
    add_recordings,
    create_store,
    item_of,
    join_ratings,
    open_store,
)
from tactogram.datasets.ratings.ratings import read_ratings, write_ratings
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal

FACTS = {"name": "test", "licence": "CC0-1.0"}
ROWS = [
    ("r1", "plate01", "rough", 6.0),
    ("r1", "plate01", "sleek", 2.0),
    ("r2", "plate01", "rough", 4.0),
    ("r1", "signal01", "rough", 1.0),
    ("r1", "signal01", "sleek", 7.0),
]


def table(rows=ROWS, **changes):
    rater, item, word, score = zip(*rows, strict=True)
    return Ratings(rater, item, word, np.array(score), **changes)


def recording(seed, **known):
    samples = np.random.default_rng(seed).standard_normal(50)
    return Recording(streams={"strain": Signal(samples, 100.0, "V")}, source=f"{seed}.wav", **known)


def surfaces():
    return [recording(1, material="plate01"), recording(2, labels={"item": "signal01"})]


class TestRatings:
    def test_the_cube_has_a_hole_where_nothing_was_said(self):
        ratings = table()
        assert (ratings.items, ratings.raters, ratings.words) == (
            ("plate01", "signal01"),
            ("r1", "r2"),
            ("rough", "sleek"),
        )
        np.testing.assert_array_equal(ratings.cube, [[[6, 2], [4, np.nan]], [[1, 7], [np.nan, np.nan]]])
        np.testing.assert_array_equal(ratings.means, [[5, 2], [1, 7]])

    def test_a_word_that_nobody_scored_has_no_mean_and_no_warning(self):
        ratings = table(words=("dry", "rough", "sleek"))
        assert np.isnan(ratings.means[:, 0]).all()
        assert np.isnan(ratings.rated("plate01").means[0])

    def test_two_sessions_of_one_rater_count_as_their_mean(self):
        rows = [("r", "p", "rough", 2.0), ("r", "p", "rough", 5.0)]
        assert table(rows, session=("monday", "tuesday")).cube[0, 0, 0] == 3.5

    def test_an_items_scores_are_0_to_1_of_those_who_rated_it(self):
        rated = table().rated("signal01")
        assert (rated.raters, rated.words) == (("r1",), ("rough", "sleek"))
        np.testing.assert_array_equal(rated.scores, [[0, 1]])
        with pytest.raises(ParameterError, match="one of the 2 that were rated, got 'p3'"):
            table().rated("p3")

    def test_an_item_is_in_it_if_it_was_rated(self):
        assert "plate01" in table()
        assert "plate02" not in table()
        assert None not in table()

    @given(st.floats(0, 1), st.sampled_from([SEVEN_POINT, EVOKED, Scale("bipolar", -3, 3)]))
    def test_unit_scores_come_back(self, share, scale):
        assert scale.to_unit(scale.from_unit(share)) == pytest.approx(share, abs=1e-12)

    def test_seven_points_are_x_minus_1_over_6(self):
        np.testing.assert_allclose(SEVEN_POINT.to_unit(np.array([1.0, 4.0, 7.0])), [0, 0.5, 1])

    @pytest.mark.parametrize("changes", [{"low": 7, "high": 1}, {"high": np.inf}, {"step": 0}, {"step": 9.0}])
    def test_a_scale_that_is_none_is_refused(self, changes):
        with pytest.raises(ParameterError, match="scale"):
            Scale(**({"name": "x", "low": 1.0, "high": 7.0} | changes))

    @pytest.mark.parametrize(
        ("row", "changes", "says"),
        [
            (
                ("r3", "p", "rough", 8.0),
                {},
                r"row 6 \(r3, p, rough\): score must be 1 to 7 in steps of 1, got 8",
            ),
            (("r3", "p", "rough", 2.5), {}, "row 6 .*got 2.5"),
            (("r3", "p", "rough", np.nan), {}, "row 6 .*got nan"),
            (
                ("r3", "p", "ruff", 3.0),
                {"words": ("rough", "sleek")},
                "row 6 .*one of rough, sleek, got 'ruff'",
            ),
            (("r1", "plate01", "rough", 5.0), {}, "row 6 .*row 1 is the same rating"),
        ],
    )
    def test_what_nobody_can_have_said_is_refused_with_its_row(self, row, changes, says):
        with pytest.raises(DataError, match=says):
            table([*ROWS, row], **changes)

    def test_columns_and_words_must_fit(self):
        with pytest.raises(ParameterError, match="one length, got 1 raters and 2"):
            Ratings(("r",), ("p", "q"), ("rough",), np.array([1.0]))
        with pytest.raises(ParameterError, match="words must differ"):
            table(words=("rough", "sleek", "rough"))
        with pytest.raises(DataError, match="must have a row"):
            Ratings((), (), (), np.zeros(0))

    def test_the_hash_is_of_what_was_said_and_not_of_its_order(self):
        assert table(ROWS[::-1], words=("rough", "sleek")).sha256 == table().sha256
        others = [
            table([*ROWS[:-1], ("r1", "signal01", "sleek", 6.0)]),
            table(scale=Scale("7-point", 1, 7)),
            table(words=("sleek", "rough")),
            table(order=np.arange(5)),
        ]
        assert len({table().sha256, *(other.sha256 for other in others)}) == 5

    def test_a_selection_keeps_words_and_scale(self):
        chosen = table().select(items=["plate01"], raters=["r2"])
        assert (len(chosen), chosen.words, chosen.scale) == (1, ("rough", "sleek"), SEVEN_POINT)

    def test_it_cannot_be_changed(self):
        given = np.array([1.0])
        ratings = Ratings(("r",), ("p",), ("rough",), given)
        given[0] = 7.0
        assert ratings.score[0] == 1.0
        for array in (ratings.score, ratings.order, ratings.cube):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 2

    def test_tables_are_joined_if_they_are_of_one_kind(self):
        plates, signals = table(ROWS[:3]), table(ROWS[3:])
        assert join_ratings([plates, signals]).sha256 == table().sha256
        with pytest.raises(DataError, match="row 4 .*row 1 is the same"):
            join_ratings([plates, plates])
        with pytest.raises(DataError, match="one scale and the same words"):
            join_ratings([plates, table(ROWS[3:], scale=Scale("x", 1, 7))])

    def test_words_are_brought_into_the_order_of_what_they_are_held_against(self):
        ratings = table(words=("rough", "sleek", "dry"))
        turned = ratings.in_words(("dry", "sleek", "rough"))
        assert turned.words == ("dry", "sleek", "rough")
        np.testing.assert_array_equal(turned.cube, ratings.cube[..., ::-1])
        with pytest.raises(DataError, match="must be of rough, loud, got rough, sleek, dry"):
            ratings.in_words(("rough", "loud"))


class TestFile:
    def test_what_goes_in_comes_out(self, tmp_path):
        ratings = table(order=np.arange(1, 6), session=tuple("aabbb"), words=("sleek", "rough", "dry"))
        write_ratings(tmp_path / "r.parquet", ratings)
        back = read_ratings(tmp_path / "r.parquet")
        assert back.sha256 == ratings.sha256
        assert (back.words, back.scale, back.session) == (ratings.words, ratings.scale, ratings.session)
        assert [path.name for path in tmp_path.iterdir()] == ["r.parquet"]

    @pytest.mark.parametrize("scale", [None, {"name": "x"}, {"name": "x", "low": 3, "high": 1}])
    def test_another_file_is_refused_by_name(self, tmp_path, scale):
        path = tmp_path / "r.parquet"
        write_ratings(path, table())
        about = {} if scale is None else {"tactogram": json.dumps({"scale": scale, "words": ["rough"]})}
        pq.write_table(pq.read_table(path).replace_schema_metadata(about), path)
        with pytest.raises(DataError, match="r.parquet: not a table of ratings"):
            read_ratings(path)

    def test_bytes_are_refused_by_name(self, tmp_path):
        (tmp_path / "r.parquet").write_bytes(b"rater,item")
        with pytest.raises(DataError, match="r.parquet: not a table of ratings"):
            read_ratings(tmp_path / "r.parquet")


class TestStore:
    def test_a_store_keeps_them_and_its_hash_says_so(self, tmp_path):
        bare = create_store(tmp_path / "bare", surfaces(), **FACTS)
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        assert bare.ratings is None
        assert store.ratings.sha256 == table().sha256 == store.facts.ratings_sha256
        assert store.sha256 != bare.sha256
        assert problems(store) == []

    def test_ratings_and_images_may_stand_alone(self, tmp_path):
        image = Image(np.full((8, 8, 3), 7, np.uint8))
        evoked = table([("r1", "image001", "rough", 1.0)], scale=EVOKED)
        store = create_store(tmp_path / "s", [], photographs=[("image001", image)], ratings=evoked, **FACTS)
        assert (len(store), store.ratings.items, store.ratings.scale) == (0, ("image001",), EVOKED)
        assert problems(store) == []

    def test_what_is_not_there_cannot_have_been_rated(self, tmp_path):
        with pytest.raises(DataError, match="items in the store, got signal01; an item is"):
            create_store(tmp_path / "s", surfaces()[:1], ratings=table(), **FACTS)
        assert list(tmp_path.iterdir()) == []

    def test_one_signal_cannot_be_two_items(self, tmp_path):
        twice = [recording(1, labels={"item": "signal01"}), recording(1, labels={"item": "signal02"})]
        with pytest.raises(
            DataError, match="the same samples as 1.wav, but called 'signal02' here and 'signal01'"
        ):
            create_store(tmp_path / "s", twice, **FACTS)

    def test_recordings_that_are_added_leave_them(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        bigger = add_recordings(store, [recording(3, material="plate02")])
        assert bigger.ratings.sha256 == table().sha256
        assert bigger.sha256 != store.sha256
        assert problems(bigger) == []

    def test_a_changed_or_missing_file_is_a_problem(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        path = store.path / store.facts.ratings.file
        path.write_bytes(path.read_bytes()[:-1] + b"x")
        assert ["sha256 differs" in line for line in problems(store)] == [True]
        path.unlink()
        assert ["missing" in line for line in problems(store)] == [True]

    def test_a_hash_that_is_not_theirs_is_a_problem(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        facts = json.loads((store.path / "dataset.json").read_text())
        facts["ratings_sha256"] = table(ROWS[:3]).sha256
        (store.path / "dataset.json").write_text(json.dumps(facts))
        assert problems(open_store(store.path)) != []

    def test_ratings_are_added_once_and_replaced_when_it_is_said(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), **FACTS)
        rated = add_ratings(store, table())
        assert rated.ratings.sha256 == table().sha256
        assert len(rated) == len(store)
        with pytest.raises(DataError, match=r"has ratings already \(5 scores\); set replace"):
            add_ratings(rated, table(ROWS[:3]))
        again = add_ratings(rated, table(ROWS[:3]), replace=True)
        assert len(again.ratings) == 3
        assert len(list(again.path.glob("ratings-*"))) == 1
        assert problems(again) == []

    def test_ratings_that_are_refused_leave_the_store_as_it_was(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        before = sorted((p.name, p.stat().st_size) for p in store.path.iterdir())
        strange = table([("r", "plate99", "rough", 1.0)])
        with pytest.raises(DataError, match="got plate99"):
            add_ratings(store, strange, replace=True)
        assert sorted((p.name, p.stat().st_size) for p in store.path.iterdir()) == before
        assert open_store(store.path).ratings.sha256 == table().sha256

    def test_the_same_ratings_again_change_nothing_but_the_file(self, tmp_path):
        store = create_store(tmp_path / "s", surfaces(), ratings=table(), **FACTS)
        again = add_ratings(store, table(ROWS[::-1], words=("rough", "sleek")), replace=True)
        assert again.sha256 == store.sha256
        assert problems(again) == []


class TestExamples:
    def test_an_example_brings_what_was_said_of_it(self, tmp_path):
        records = [*surfaces(), recording(3, material="plate02")]
        store = create_store(tmp_path / "s", records, ratings=table(), **FACTS)
        segments = tuple(Segment(info.id) for info in store.index)
        plate, signal, unrated = Examples(store, segments, Preparation(stream="strain"))
        assert (plate.item, signal.item, unrated.item) == ("plate01", "signal01", "plate02")
        np.testing.assert_allclose(plate.rated.scores, [[5 / 6, 1 / 6], [0.5, np.nan]])
        assert signal.material is None
        assert unrated.rated is None

    def test_an_item_is_its_label_else_its_material(self):
        assert item_of(recording(1, material="cork")) == "cork"
        assert item_of(recording(1, material="cork", labels={"item": "cork, wet"})) == "cork, wet"
        assert item_of(recording(1)) is None
