import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.features.registered_pairs import (
    PARTS,
    PhotoWindows,
    RegisteredPairs,
    photograph_of,
    scaled,
)
from tactogram.model import Example
from tactogram.signal import Image, Signal

PUBLISHED = PhotoWindows()
SMALL = {"pixels": 16, "samples": 20, "offset": 2, "most": None}


def ramp(name="felt", width=100, mm_per_pixel=0.1, rate=12.5, brightness=1.0, rows=20):
    """A photograph as bright as its column, and a friction of the same column: 100 columns, 10 mm."""
    columns = np.broadcast_to(brightness * np.arange(width), (rows, width))
    pixels = np.repeat(columns[..., None], 3, 2).astype(np.uint8)
    scale = 0.1 if mm_per_pixel is None else mm_per_pixel
    x = np.arange(round(width * scale * rate)) / rate
    signal = Signal(x / scale, rate, "1", ("along",), "displacement")
    return Example(name, signal, name, {"image": Image(pixels, mm_per_pixel)})


def columns_of(batch):
    """The first column of each window, from its brightness, and that of its friction."""
    seen = (batch.photo[:, 0, 0, 0].numpy() + 1) * 127.5
    return seen, batch.friction[:, 0, 0].numpy()


def test_a_photograph_of_2362_pixels_holds_670_windows_of_which_600_are_taken():
    """(2362 - 1024) / 2 + 1; the paper counts 669."""
    assert len(PhotoWindows(most=None, protocol="examples").lefts(2362, None)) == 670
    assert PUBLISHED.lefts(2362, None).tolist() == list(range(0, 1200, 2))


def test_window_split_is_400_100_100_of_each_photograph_and_leaks():
    """Cai et al., Sec. 4: "2000, 500, 500 pairs" of five fabrics."""
    parts = [PUBLISHED.lefts(2362, part) for part in PARTS]
    assert [5 * len(p) for p in parts] == [2000, 500, 500]
    assert len(np.unique(np.concatenate(parts))) == 600
    neighbours = np.abs(parts[2][:, None] - parts[0][None]).min(1)
    assert (
        neighbours <= 4
    ).mean() > 0.95  # nearly every test window has a training window 2 or 4 pixels beside it


@settings(max_examples=40, deadline=None)
@given(width=st.integers(400, 3000), pixels=st.integers(8, 64), offset=st.integers(1, 9))
def test_region_split_shares_no_pixel(width, pixels, offset):
    windows = PhotoWindows(
        pixels=pixels,
        samples=2 * pixels,
        offset=offset,
        most=None,
        protocol="region-split",
        shares=(0.5, 0.25, 0.25),
    )
    ends = [(int(p[0]), int(p[-1]) + pixels) for p in (windows.lefts(width, part) for part in PARTS)]
    assert ends[0][1] <= ends[1][0]
    assert ends[1][1] <= ends[2][0]
    assert ends[2][1] <= width


def test_region_split_shares_no_pixel_between_a_long_and_a_short_recording_of_one_photograph():
    long = ramp("long")
    short = Example("short", long.signal.cut(0, 100), "felt", long.condition)
    windows = PhotoWindows(protocol="region-split", shares=(0.5, 0.25, 0.25), **SMALL)
    parts = [RegisteredPairs([long, short], windows, part=part) for part in PARTS]
    lefts = [np.concatenate(pairs._lefts) for pairs in parts]
    assert lefts[0].max() + 16 <= lefts[1].min()
    assert lefts[1].max() + 16 <= lefts[2].min()


def test_a_window_is_paired_with_the_friction_under_it():
    """Cai et al. 2020, Sec. 4: "one-to-one corresponding relations between images and amplitude spectrograms"."""
    pairs = RegisteredPairs([ramp()], PhotoWindows(protocol="examples", **SMALL))
    batch = pairs.batch(range(len(pairs)))
    seen, felt = columns_of(batch)
    np.testing.assert_allclose(seen, batch.places[:, 1], atol=1e-3)
    np.testing.assert_allclose(felt, batch.places[:, 1], atol=0.45)  # nearest sample: within 0.4 pixels
    assert batch.friction.shape == (43, 1, 20)
    np.testing.assert_allclose(np.diff(batch.friction[:, 0].numpy(), axis=1), 16 / 20, atol=0.02)


def test_a_window_ends_where_the_friction_does():
    short = ramp()
    short = Example("felt", short.signal.cut(0, 75), "felt", short.condition)  # 60 of 100 columns
    pairs = RegisteredPairs([short], PhotoWindows(protocol="examples", **SMALL))
    assert pairs.batch([len(pairs) - 1]).places[0, 1] == 44


def test_photographs_are_resized_to_one_scale():
    fine = ramp("fine", width=200, mm_per_pixel=0.05, brightness=0.5, rows=40)
    pairs = RegisteredPairs([ramp(), fine], PhotoWindows(protocol="examples", **SMALL))
    assert (pairs.mm_per_pixel, len(pairs.of(0)), len(pairs.of(1))) == (0.1, 43, 43)
    batch = pairs.batch(pairs.of(1)[10:12])
    seen, felt = columns_of(batch)
    np.testing.assert_allclose(seen, [20, 22], atol=1)
    np.testing.assert_allclose(felt, [40, 44], atol=1)  # its columns are half as wide
    assert scaled(fine.condition["image"], 0.1).pixels.shape == (20, 100, 3)


def test_without_a_scale_pairs_are_of_a_recording_only_and_regions_are_kept_apart_in_both():
    windows = PhotoWindows(protocol="region-split", shares=(0.5, 0.25, 0.25), **SMALL)
    examples = [ramp(mm_per_pixel=None)]
    for part, low, high in zip(PARTS, (0, 50, 75), (50, 75, 100), strict=True):
        pairs = RegisteredPairs(examples, windows, part=part)
        assert pairs.registered == [False]
        seen, felt = columns_of(pairs.batch(range(len(pairs)), seed=3))
        assert seen.min() >= low - 1e-3
        assert seen.max() + 16 <= high + 1e-3
        assert felt.min() >= low - 0.5
        assert felt.max() + 0.8 * 19 < high
        again = columns_of(pairs.batch(range(len(pairs)), seed=4))[1]
        assert not np.array_equal(felt, again)


def test_an_epoch_holds_every_window_once_and_few_photographs_at_a_time(monkeypatch):
    monkeypatch.setattr("tactogram.features.registered_pairs.CACHED_BYTES", 4 * 16 * 100 * 3)
    examples = [ramp(str(k)) for k in range(7)]
    pairs = RegisteredPairs(examples, PhotoWindows(protocol="examples", **SMALL))
    order = pairs.order(seed=1)
    epoch = [next(order) for _ in range(len(pairs))]
    assert sorted(epoch) == list(range(len(pairs)))
    first = {int(pairs.batch([place]).places[0, 0]) for place in epoch[: 43 * 4]}
    assert len(first) == pairs.cached == 4
    assert len(pairs._photos) == 4
    other = pairs.order(seed=2)
    assert [next(other) for _ in range(40)] != epoch[:40]


def test_larger_photographs_shrink_the_cache(monkeypatch):
    monkeypatch.setattr("tactogram.features.registered_pairs.CACHED_BYTES", 4 * 16 * 100 * 3)
    examples = [*(ramp(str(k)) for k in range(4)), ramp("wide", width=200)]
    pairs = RegisteredPairs(examples, PhotoWindows(protocol="examples", **SMALL))
    pairs.batch([0])
    assert len(pairs._photos) == pairs.cached == 2


def test_grey_windows_have_one_channel():
    pairs = RegisteredPairs([ramp()], PhotoWindows(protocol="examples", grey=True, **SMALL))
    assert pairs.batch([0, 1]).photo.shape == (2, 1, 16, 16)


def test_the_surfaces_photograph_replaces_a_missing_one_of_the_recording():
    image = ramp().condition["image"]
    assert photograph_of(Example("a", ramp().signal, "a", {}, (image,))) is image


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: RegisteredPairs([], PUBLISHED), "no examples"),
        (lambda: RegisteredPairs([Example("a", ramp().signal)], PUBLISHED), "recording a has no photograph"),
        (lambda: RegisteredPairs([ramp()], PUBLISHED), "100 x 20 pixels holds no window of 1024"),
        (lambda: PUBLISHED.lefts(1000, "train"), "1000 usable columns"),
        (lambda: PUBLISHED.window(ramp().condition["image"], 0), "100 x 20 pixels holds no window of 1024"),
        (lambda: PhotoWindows(protocol="random"), "protocol must be one of"),
        (lambda: PhotoWindows(pixels=0), "at least 1"),
        (lambda: PhotoWindows(shares=(1.0, 0.5, -0.5)), "add up to 1"),
    ],
)
def test_refused(call, message):
    with pytest.raises(ParameterError, match=message):
        call()
