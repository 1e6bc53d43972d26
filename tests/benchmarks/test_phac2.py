import numpy as np
import pytest
from benchmarks.experiments.phac2 import read_phac2

from tactogram.datasets import EVOKED
from tactogram.errors import DataError


def write(folder, *, csv="object_id,object,trials,soft,hard\n7,sponge,2,1,0\n9,sponge,1,0,1\n", **changes):
    arrays = {
        "features": np.arange(24.0).reshape(3, 2, 4),
        "phases": np.array(["HOLD", "SLIDE"]),
        "trial_names": np.array(["sponge_7_01", "sponge_9_01", "sponge_7_02"]),
        "object_ids": np.array([7, 9, 7], np.int32),
        "adjectives": np.array(["hard", "soft"]),
        "labels": np.array([[0, 1], [1, 0], [0, 1]], np.int8),
    }
    folder.mkdir(exist_ok=True)
    (folder / "object_adjectives.csv").write_text(csv)
    np.savez(folder / "phac2_static_features.npz", **(arrays | changes))
    return folder


def test_objects_of_one_name_are_told_apart(tmp_path):
    data = read_phac2(write(tmp_path / "p"))
    assert data.objects == ("sponge_7", "sponge_9")
    np.testing.assert_array_equal(data.trial_object, [0, 1, 0])
    np.testing.assert_array_equal(data.table, [[True, False], [False, True]])
    assert data.adjectives == ("soft", "hard")
    np.testing.assert_array_equal(data.labels, [[1, 0], [0, 1], [1, 0]])
    np.testing.assert_array_equal(data.features[1], np.arange(8.0, 16.0))


def test_adjectives_are_ratings_by_a_group(tmp_path):
    ratings = read_phac2(write(tmp_path / "p")).ratings
    assert (ratings.scale, ratings.raters, ratings.words) == (EVOKED, ("group",), ("soft", "hard"))
    np.testing.assert_array_equal(ratings.rated("sponge_9").scores, [[0, 1]])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"features": np.full((3, 2, 4), np.nan)}, "features must be finite, got 24"),
        ({"features": np.zeros((2, 2, 4))}, "of 3 trials, got"),
        ({"object_ids": np.array([7, 8, 7])}, "among those of object_adjectives.csv, got 8"),
        ({"adjectives": np.array(["hard", "softly"])}, "must have the adjectives of"),
        ({"labels": np.ones((3, 2))}, "labels must be those of object_adjectives.csv"),
        (
            {"csv": "object_id,object,trials,soft,hard\n7,sponge,2,2,0\n"},
            "soft of sponge must be 0 or 1, got '2'",
        ),
        ({"csv": "object_id,object,trials,soft\n7,a,2,1\n7,b,1,0\n"}, "must have a different id"),
        ({"csv": "object,soft\n"}, "needs columns object_id, object"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path, changes, says):
    with pytest.raises(DataError, match=says):
        read_phac2(write(tmp_path / "p", **changes))


def test_missing_files_are_named(tmp_path):
    with pytest.raises(DataError, match="object_adjectives.csv: no such file"):
        read_phac2(tmp_path)
    (write(tmp_path / "p") / "phac2_static_features.npz").write_bytes(b"no")
    with pytest.raises(DataError, match="phac2_static_features.npz: not an NPZ file"):
        read_phac2(tmp_path / "p")


@pytest.mark.real_data
def test_real_files(real_data):
    data = read_phac2(real_data("phac2_adjectives"))
    assert data.features.shape == (600, 4 * 47)
    assert (len(data.objects), len(set(data.objects)), len(data.adjectives)) == (60, 60, 24)
    assert (np.bincount(data.trial_object) == 10).all()
    assert all(
        trial.rsplit("_", 1)[0] == data.objects[n]
        for trial, n in zip(data.trials, data.trial_object, strict=True)
    )
    alone = [name for name, count in zip(data.adjectives, data.table.sum(0), strict=True) if count == 1]
    assert alone == ["nice", "sticky", "unpleasant"]
    spread = data.features.std(0)
    assert spread.min() > 0
    assert len(data.ratings) == 60 * 24
