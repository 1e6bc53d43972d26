"""Photographs from files: what is converted is right, what is refused is one line with the file's name."""

import io

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image as Pillow

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import picture
from tactogram.signal.io.picture import (
    decode_image,
    is_plain,
    picture_size,
    read_image,
    read_image_metadata,
    write_image,
)
from tactogram.signal.signal import Image


def photo(rows=40, columns=60, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), dtype=np.uint8)


def encoded(image, kind="PNG", **options):
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def turned(pixels, orientation):
    exif = Pillow.Exif()
    exif[0x0112] = orientation
    return encoded(Pillow.fromarray(pixels), exif=exif)


@pytest.mark.parametrize("kind", ["PNG", "TIFF", "BMP", "PPM"])
def test_pixels_come_as_they_are(tmp_path, kind):
    path = tmp_path / "a.jpg"  # the suffix decides nothing
    path.write_bytes(encoded(Pillow.fromarray(photo()), kind))
    image = read_image(path, width_mm=30.0)
    np.testing.assert_array_equal(image.pixels, photo())
    assert image.mm_per_pixel == 0.5
    assert picture_size(path.read_bytes(), name="a") == image.size == (40, 60)


def test_sixteen_bits_are_scaled_not_clipped():
    values = np.array([[0, 128, 129, 257, 32768, 65535]], np.uint16)
    image = decode_image(encoded(Pillow.fromarray(values)), name="deep.png")
    np.testing.assert_array_equal(image.pixels[0, :, 0], np.round(values[0] / 257))
    assert (image.pixels == image.pixels[..., :1]).all()


def test_thirty_two_bits_that_hold_sixteen_are_scaled_and_others_refused():
    assert (
        decode_image(encoded(Pillow.fromarray(np.array([[257]], np.int32)), "TIFF"), name="a").pixels.max()
        == 1
    )
    with pytest.raises(DataError, match=r"deep.tif: pixels must have at most 16 bits, got -1 to 70000"):
        decode_image(encoded(Pillow.fromarray(np.array([[-1, 70000]], np.int32)), "TIFF"), name="deep.tif")


def test_transparent_pixels_lie_on_white():
    pixels = np.zeros((1, 3, 4), np.uint8)
    pixels[0, :, 3] = [0, 128, 255]
    image = decode_image(encoded(Pillow.fromarray(pixels)), name="a")
    np.testing.assert_array_equal(image.pixels[0, :, 0], [255, 127, 0])


def test_a_transparent_colour_of_a_palette_lies_on_white():
    drawn = Pillow.new("P", (2, 1))
    drawn.putpalette([0, 0, 0, 10, 20, 30])
    drawn.putpixel((1, 0), 1)
    image = decode_image(encoded(drawn, transparency=0), name="a")
    np.testing.assert_array_equal(image.pixels[0], [[255, 255, 255], [10, 20, 30]])


def test_cmyk_becomes_rgb():
    image = decode_image(encoded(Pillow.new("CMYK", (8, 8), (255, 0, 0, 0)), "JPEG"), name="a")
    assert np.abs(image.pixels.astype(int) - [0, 255, 255]).max() <= 2


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_photograph_stands_upright(orientation):
    undone = {
        1: lambda p: p,
        2: lambda p: p[:, ::-1],
        3: lambda p: p[::-1, ::-1],
        4: lambda p: p[::-1],
        5: lambda p: p.transpose(1, 0, 2),
        6: lambda p: np.rot90(p, -1),
        7: lambda p: np.rot90(p, 2).transpose(1, 0, 2),
        8: lambda p: np.rot90(p, 1),
    }
    data = turned(photo(), orientation)
    image = decode_image(data, name="a", width_mm=30.0)
    np.testing.assert_array_equal(image.pixels, undone[orientation](photo()))
    assert picture_size(data, name="a") == image.size
    assert image.mm_per_pixel == 30.0 / image.size[1]
    assert is_plain(data, name="a") == (orientation == 1)


def test_a_tiny_picture_is_a_picture():
    assert decode_image(encoded(Pillow.new("L", (1, 1), 7)), name="a").pixels.tolist() == [[[7, 7, 7]]]


def test_a_long_thin_picture_is_read():
    assert decode_image(encoded(Pillow.new("L", (20_000, 3))), name="a").size == (3, 20_000)


@pytest.mark.parametrize("size", [(20_000, 20_000), (8193, 8192)])
def test_a_decompression_bomb_is_refused_before_it_is_unpacked(size, monkeypatch):
    bomb = encoded(Pillow.new("1", size))
    assert len(bomb) < 1e5
    monkeypatch.setattr(Pillow.Image, "load", lambda *_: pytest.fail("unpacked"))
    with pytest.raises(DataError, match=r"^bomb.png: a picture must have at most 67108864 pixels"):
        decode_image(bomb, name="bomb.png")


BROKEN = {
    "text": b"no picture at all",
    "empty": b"",
    "truncated png": encoded(Pillow.fromarray(photo()))[:2000],
    "truncated jpeg": encoded(Pillow.fromarray(photo()), "JPEG")[:900],
    "only a head": encoded(Pillow.fromarray(photo()))[:20],
    "floats": encoded(Pillow.fromarray(np.zeros((2, 2), np.float32)), "TIFF"),
    "a program": b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 10 10\nshowpage\n",
}


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_no_picture_is_refused_in_one_line_with_its_name(tmp_path, kind):
    path = tmp_path / "surface.png"
    path.write_bytes(BROKEN[kind])
    with pytest.raises(DataError) as caught:
        read_image(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert "0x" not in message  # no object's address


def test_no_file_and_a_folder_are_refused(tmp_path):
    for path in (tmp_path / "none.png", tmp_path):
        with pytest.raises(DataError, match="no such file|is a folder"):
            read_image(path)


def test_two_scales_are_refused():
    with pytest.raises(ParameterError, match="got both"):
        decode_image(encoded(Pillow.new("L", (2, 2))), name="a", mm_per_pixel=1.0, width_mm=2.0)


@given(
    place=st.integers(0, 10_000),
    byte=st.integers(0, 255),
    length=st.integers(0, 8),
    kind=st.sampled_from(["PNG", "JPEG", "TIFF", "GIF"]),
)
def test_damage_anywhere_is_a_picture_or_one_line(place, byte, length, kind):
    data = bytearray(encoded(Pillow.fromarray(photo(12, 9)), kind))
    place %= len(data)
    data[place : place + length] = bytes([byte]) * length
    try:
        image = decode_image(bytes(data), name="a")
    except DataError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert image.size[0] * image.size[1] <= picture.MOST_PIXELS


def test_an_image_is_written_whole_with_what_is_known_of_it(tmp_path):
    image = Image(np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8))
    facts = {"simulated": True, "words": {"rough": 6.0, "ざらざらする": 2}}
    write_image(tmp_path / "new" / "x.png", image, metadata=facts)
    np.testing.assert_array_equal(read_image(tmp_path / "new" / "x.png").pixels, image.pixels)
    assert read_image_metadata(tmp_path / "new" / "x.png") == facts
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["x.png"]


def test_a_foreign_picture_says_nothing(tmp_path):
    Pillow.new("RGB", (2, 2)).save(tmp_path / "x.png")
    assert read_image_metadata(tmp_path / "x.png") == {}


@pytest.mark.parametrize(
    ("name", "metadata", "message"),
    [("x.jpg", {}, "written as .png, got '.jpg'"), ("x.png", {"a": np.nan}, "metadata must be JSON")],
)
def test_what_an_image_file_cannot_hold_is_refused(tmp_path, name, metadata, message):
    with pytest.raises(ParameterError, match=message):
        write_image(tmp_path / name, Image(np.zeros((2, 2, 3), np.uint8)), metadata=metadata)
    assert not any(tmp_path.iterdir())


def test_a_photograph_of_a_phone_is_read(tmp_path):
    heif = pytest.importorskip("pillow_heif")
    heif.register_heif_opener()
    Pillow.new("RGB", (64, 48), (200, 100, 50)).save(tmp_path / "a.heic", quality=95)
    image = read_image(tmp_path / "a.heic")
    assert image.pixels.shape == (48, 64, 3)
    np.testing.assert_allclose(image.pixels.mean(axis=(0, 1)), (200, 100, 50), atol=4)
