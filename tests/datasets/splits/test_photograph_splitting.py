"""No pixel on two sides: photographs held out whole or cut into regions."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st
from tests.datasets.store.sample_photographs import by_recording, examples, picture, recording, store_of

from tactogram.datasets import (
    Examples,
    Recording,
    Segment,
    Split,
    add_recordings,
    contiguous_blocks,
    create_store,
    materials_without_photographs,
    materials_without_recordings,
    require_photographs,
    split_fractions,
    split_photographs,
    whole_photographs,
)
from tactogram.datasets.splits.photograph_splitting import cut_photograph
from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal

PARTS = ("train", "validation", "test")


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    counts=st.lists(st.integers(0, 12), min_size=1, max_size=4),
    takes=st.integers(1, 9),
    by=st.sampled_from(["recording", "material"]),
    own=st.booleans(),
    gap=st.integers(0, 20),
    seed=st.integers(0, 99),
)
def test_no_pixel_is_on_two_sides_and_every_part_has_a_photograph(
    tmp_path_factory, counts, takes, by, own, gap, seed
):
    counts = {f"m{i}": count for i, count in enumerate(counts)}
    images = {"m0": picture(99)} if own else None
    store = store_of(tmp_path_factory.mktemp("p"), counts, takes=takes, images=images)
    try:
        plain = split_fractions(store.index, by=by, test=0.2, validation=0.2, seed=seed)
    except ParameterError:
        assume(False)
    split = split_photographs(store, plain, seed=seed, gap=gap, smallest=8)

    pixels: dict[str, dict[str, np.ndarray]] = {}
    for part in PARTS:
        for region in split.photographs[part]:
            mask = pixels.setdefault(region.key, {}).setdefault(
                part, np.zeros(store.photograph_size(region.key), bool)
            )
            mask[region.top : region.bottom, region.left : region.right] = True
    for masks in pixels.values():
        for one, other in combinations(masks.values(), 2):
            assert not (one & other).any()
    for part in PARTS:
        for example in examples(store, split, part):
            having = counts[example.material] or (own and example.material == "m0")
            assert bool(len(example.photographs)) == bool(having)
    used = {region.key for regions in split.photographs.values() for region in regions}
    assert used == set(store.photograph_keys())
    assert set(split.by_region) <= counts.keys()
    again = split_photographs(store, plain, seed=seed, gap=gap, smallest=8)
    assert again == split


def test_ten_photographs_are_dealt_eight_one_one(tmp_path):
    store = store_of(tmp_path, {"cork": 10, "tile": 10})
    split = split_photographs(store, by_recording(store), seed=0)
    for material in ("cork", "tile"):
        held = {
            p: [r for r in split.photographs[p] if r.key in store.photographs_of(material)] for p in PARTS
        }
        assert {p: len(regions) for p, regions in held.items()} == {"train": 8, "validation": 1, "test": 1}
        assert all(region.whole for regions in held.values() for region in regions)
    assert split.by_region == ()
    assert (
        split.photograph_note
        == "of 2 materials photographs were held out whole: surfaces seen, photographs not"
    )


@pytest.mark.parametrize("count", [1, 2])
def test_few_photographs_are_cut_and_the_split_says_so(tmp_path, count):
    store = store_of(tmp_path, {"cork": count, "tile": 10})
    split = split_photographs(store, by_recording(store), seed=0, gap=8, smallest=16)
    assert split.by_region == ("cork",)
    assert "disjoint regions of the same one, 8 pixels apart" in split.photograph_note
    assert "cork" in split.photograph_note
    for part in PARTS:
        [example, *_] = [e for e in examples(store, split, part) if e.material == "cork"]
        assert len(example.photographs) == count
        for image, region in zip(example.photographs, example.photographs.regions, strict=True):
            whole = store.photograph(region.key)
            expected = whole.pixels[region.top : region.bottom, region.left : region.right]
            np.testing.assert_array_equal(image.pixels, expected)
            assert min(image.size) >= 16
            assert image.mm_per_pixel == 0.1


def test_regions_of_other_photographs_lie_elsewhere(tmp_path):
    random = np.random.default_rng(0)
    tops = {
        cut_photograph("k", (96, 80), ("train", "test"), gap=8, smallest=16, random=random)["train"].top
        for _ in range(20)
    }
    assert len(tops) == 2


def test_a_photograph_too_small_to_be_cut_is_refused(tmp_path):
    store = store_of(tmp_path, {"cork": 1})
    with pytest.raises(
        ParameterError, match=r"^photograph of cork: 96 x 80 pixels are too few to be cut into 3"
    ):
        split_photographs(store, by_recording(store), seed=0, smallest=60)


def test_photographs_follow_their_material(tmp_path):
    store = store_of(tmp_path, {f"m{i}": 1 + i % 3 for i in range(10)})
    split = split_photographs(store, by_recording(store, by="material"), seed=0)
    assert split.by_region == ()
    assert "surfaces never seen" in split.photograph_note
    for part in PARTS:
        materials = {store.info(s.id).material for s in split.parts[part]}
        keys = {key for m in materials for key in store.photographs_of(m)}
        assert {region.key for region in split.photographs[part]} == keys


def test_a_recordings_own_photograph_goes_with_it(tmp_path):
    recordings = [recording("cork", i, picture(i)) for i in range(10)]
    store = create_store(tmp_path / "s", recordings, name="t", licence="CC0-1.0")
    split = split_photographs(store, by_recording(store), seed=0)
    for part in PARTS:
        own = {store.image_id(segment.id) for segment in split.parts[part]}
        assert {region.key for region in split.photographs[part]} == own
        for example in examples(store, split, part):
            assert example.condition["image"] is store.image(example.id)


def test_a_shared_photograph_is_cut_for_the_recordings_that_name_it(tmp_path):
    shared = picture(5)
    store = store_of(tmp_path, {"cork": 0}, images={"cork": shared})
    split = split_photographs(store, by_recording(store), seed=0, smallest=16)
    assert split.by_region == ("cork",)
    for part in PARTS:
        [region] = split.photographs[part]
        for example in examples(store, split, part):
            expected = shared.pixels[region.top : region.bottom, region.left : region.right]
            np.testing.assert_array_equal(example.condition["image"].pixels, expected)


def test_a_part_of_a_registered_photograph_is_registered_to_nothing(tmp_path):
    store = store_of(tmp_path, {"cork": 0}, images={"cork": picture(5)})
    split = split_photographs(store, by_recording(store), seed=0, smallest=16)
    for part in PARTS:
        for example in examples(store, split, part):
            assert example.condition["image"].mm_per_pixel is None
            assert {image.mm_per_pixel for image in example.photographs} == {0.1}
    assert Examples(store, split.train, Preparation())[0].condition["image"].mm_per_pixel == 0.1


def test_blocks_of_one_long_recording_have_regions_of_its_photograph(tmp_path):
    friction = Signal(np.random.default_rng(0).random(1000), 5.0, "1", domain="displacement")
    take = Recording(streams={"friction": friction}, material="wood", image=picture(3))
    store = create_store(tmp_path / "s", [take], name="t", licence="CC0-1.0")
    [plain, *_] = contiguous_blocks(store.index, {take.id: friction.length_mm}, blocks=4, gap_s=10.0)
    split = split_photographs(store, plain, seed=0, smallest=16)
    assert split.by_region == ("wood",)
    [test] = examples(store, split, "test")
    np.testing.assert_array_equal(test.signal.samples, friction.cut(0, 250).samples)
    [train] = examples(store, split, "train")
    assert train.photographs.regions[0].distance(test.photographs.regions[0]) == 16


def test_an_image_that_another_part_may_use_is_no_condition(tmp_path):
    shared = picture(5)
    store = store_of(tmp_path, {"cork": 9}, images={"cork": shared})
    split = split_photographs(store, by_recording(store), seed=0)
    having = [part for part in PARTS if any("image" in e.condition for e in examples(store, split, part))]
    assert len(having) == 1


def test_a_photograph_of_two_materials_recordings_is_cut_between_their_parts(tmp_path):
    shared = picture(5)
    recordings = [recording(m, i, shared) for m in ("cork", "tile") for i in range(5)]
    store = create_store(tmp_path / "s", recordings, name="t", licence="CC0-1.0")
    plain = Split(
        tuple(Segment(r.id) for r in recordings[:5]),
        (),
        tuple(Segment(r.id) for r in recordings[5:]),
        "material",
    )
    split = split_photographs(store, plain, seed=0, smallest=16)
    assert split.by_region == ("cork", "tile")
    assert [len(split.photographs[part]) for part in PARTS] == [1, 0, 1]


def test_a_split_with_photographs_comes_back(tmp_path):
    store = store_of(tmp_path, {"cork": 1, "tile": 10})
    split = split_photographs(store, by_recording(store), seed=0, smallest=16)
    split.save(tmp_path / "split.json")
    assert Split.load(tmp_path / "split.json") == split


def test_all_photographs_may_be_used_of_data_kept_apart(tmp_path):
    store = store_of(tmp_path, {"cork": 3, "tile": 2})
    assert {r.key for r in whole_photographs(store)} == set(store.photograph_keys())


def test_a_material_without_a_photograph_is_named(tmp_path):
    store = add_recordings(store_of(tmp_path, {"cork": 3, "tile": 0}), [], photographs=[("Tile", picture(3))])
    assert materials_without_photographs(store) == ("tile",)
    assert materials_without_recordings(store) == ("Tile",)
    split = split_photographs(store, by_recording(store), seed=0, smallest=8)
    train = examples(store, split, "train")
    with pytest.raises(
        ParameterError, match=r"got none of tile \(and no recording of Tile\); .*material=!tile"
    ):
        require_photographs(train)
    with pytest.raises(ParameterError, match=r"got none of tile;"):
        require_photographs(list(train))
    require_photographs([e for e in train if e.material == "cork"])


def test_without_a_split_of_photographs_examples_are_as_they_were(tmp_path):
    store = store_of(tmp_path, {"cork": 3}, images={"cork": picture(5)})
    [example, *_] = Examples(store, [Segment(info.id) for info in store.index], Preparation())
    assert len(example.photographs) == 0
    np.testing.assert_array_equal(example.condition["image"].pixels, picture(5).pixels)
