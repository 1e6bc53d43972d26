import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram_studio.workspace.shelf import FACTS, ResultArchive


@pytest.fixture
def shelf(tmp_path):
    return ResultArchive(tmp_path / "kept")


@pytest.fixture
def signal():
    samples = np.random.default_rng(0).standard_normal((3, 500)).astype(np.float32)
    return Signal(samples, 1000, "m/s^2", axes=("x", "y", "z"))


def test_a_signal_comes_back_to_the_bit_with_what_is_known_of_it(shelf, signal):
    kept = shelf.keep(signal, title="  cork\n and tile ", facts={"seed": 3, "simulated": True})

    again = shelf.get(kept.id)
    assert again.title == "cork and tile"
    assert again.facts["seed"] == 3
    assert again.facts["simulated"] is True
    np.testing.assert_array_equal(again.signal().samples, signal.samples)
    assert (again.signal().rate, again.signal().unit, again.signal().axes) == (1000, "m/s^2", ("x", "y", "z"))


def test_an_image_comes_back(shelf):
    image = Image(np.arange(48, dtype=np.uint8).reshape(4, 4, 3))

    kept = shelf.keep(image, title="sand", facts={})

    assert kept.is_image
    np.testing.assert_array_equal(kept.image().pixels, image.pixels)
    with pytest.raises(DataError, match="is an image; a signal is needed"):
        kept.signal()


def test_what_fails_on_the_way_leaves_nothing(shelf, signal):
    with pytest.raises(TypeError):
        shelf.keep(signal, title="t", facts={"not": object()})

    assert shelf.all() == []
    assert list(shelf.folder.iterdir()) == []


def test_a_result_is_renamed_and_removed(shelf, signal):
    first, second = (shelf.keep(signal, title=title, facts={"seed": 1}) for title in ("one", "two"))

    shelf.rename(first.id, "first")
    shelf.remove(second.id)

    assert [(made.title, made.facts["seed"]) for made in shelf.all()] == [("first", 1)]
    with pytest.raises(DataError, match="no kept result"):
        shelf.get(second.id)


@pytest.mark.parametrize(
    "name", ["../../etc", "", ".", "20260101-000000-123456/..", "20260101-000000-123456"]
)
def test_an_id_is_no_path(shelf, signal, name):
    shelf.keep(signal, title="one", facts={})

    with pytest.raises(DataError, match="no kept result"):
        shelf.get(name)


@pytest.mark.parametrize("text", [b"{", b"[]", b'{"title": "\xff"}', b"[" * 100_000])
def test_one_that_is_broken_is_refused_in_a_line_and_hides_no_other(shelf, signal, text):
    broken, whole = (shelf.keep(signal, title=title, facts={}) for title in ("broken", "whole"))
    (broken.folder / FACTS).write_bytes(text)

    assert [made.id for made in shelf.all()] == [whole.id]
    with pytest.raises(DataError, match=FACTS) as told:
        shelf.get(broken.id)
    assert "\n" not in str(told.value)


def test_a_title_is_needed(shelf, signal):
    with pytest.raises(ParameterError, match="needs a title"):
        shelf.keep(signal, title=" \n", facts={})


def test_the_newest_comes_first(shelf, signal):
    for title in "abcde":
        shelf.keep(signal, title=title, facts={})

    assert [made.title for made in shelf.all()] == list("edcba")


def test_a_result_of_another_shelf_is_kept_to_the_bit_with_its_facts(shelf, signal, tmp_path):
    made = ResultArchive(tmp_path / "made").keep(signal, title="cork", facts={"seed": 3})

    kept = shelf.keep_copy(made)

    assert (kept.title, kept.facts["seed"]) == ("cork", 3)
    assert kept.file.read_bytes() == made.file.read_bytes()
    made.file.unlink()
    with pytest.raises(DataError, match="cork: was deleted; make it again"):
        shelf.keep_copy(made)
    assert len(shelf.all()) == 1
