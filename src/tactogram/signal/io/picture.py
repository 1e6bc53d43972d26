"""Pictures: photographs from files as 8-bit sRGB, and images to PNG.

HEIC and HEIF, as phones take them, are read by pillow-heif (extra ``formats``).

Conversions, in this order: the picture is rotated by its EXIF tag; 16-bit grey is scaled so that 65535 becomes 255
(16-bit colour loses its low byte); transparent pixels are composited over white; CMYK, Lab, YCbCr, palettes and grey
become RGB. A colour profile inside the file is not applied. Of several pictures in one file the first is read.

Refused, in one line: files that are not one of `PICTURE_FORMATS`, truncated or damaged files, more than `MOST_PIXELS`
(before anything of that size is unpacked), and pixels without an agreed white: floating point, and whole numbers beyond
16 bits.
"""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow, ImageOps, PngImagePlugin, UnidentifiedImageError

from tactogram.errors import DataError, ParameterError
from tactogram.extras import imported
from tactogram.signal.io.archives import decoding
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.signal import Image
from tactogram.text_files import read_bytes

PICTURE_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "PPM", "HEIF")
"""Readable formats. Others of Pillow's run programs (EPS) or are no photographs."""

HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"mif1", b"msf1")
MOST_PIXELS = 2**26
"""8192 x 8192, 192 MiB unpacked: more than any camera's texture photo, far less than a decompression bomb."""
EXIF_ORIENTATION = 0x0112
NOT_READABLE = "not a readable picture"
METADATA = "tactogram"
"""Key of the PNG text with an image's metadata as JSON."""


def read_image(
    path: Path | str, *, mm_per_pixel: float | None = None, width_mm: float | None = None
) -> Image:
    """Return the photograph in a file; errors are a `DataError` that names the file.

    The format, one of `PICTURE_FORMATS`, follows from the first bytes, not from the suffix. The scale is optional, per
    pixel or for the width of the upright picture.
    """
    return decode_image(picture_bytes(path), name=str(path), mm_per_pixel=mm_per_pixel, width_mm=width_mm)


def write_image(path: Path | str, image: Image, *, metadata: Mapping[str, Any] | None = None) -> None:
    """Write an image as PNG, atomically; `read_image` returns its pixels and `read_image_metadata` its metadata."""
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ParameterError(f"{path}: an image is written as .png, got {path.suffix or 'no suffix'!r}")
    text = PngImagePlugin.PngInfo()
    try:
        text.add_itxt(METADATA, json.dumps(dict(metadata or {}), ensure_ascii=False, allow_nan=False))
    except (TypeError, ValueError) as error:
        raise ParameterError.must("metadata", f"be JSON: {error}") from error
    with atomic_write(path) as part:
        Pillow.fromarray(image.pixels).save(part, format="PNG", pnginfo=text)


def read_image_metadata(path: Path | str) -> dict[str, Any]:
    """Return the metadata of `write_image`, of another picture nothing; `DataError` if unreadable."""
    return decode_image_metadata(picture_bytes(path), name=str(path))


def decode_image_metadata(data: bytes, *, name: str) -> dict[str, Any]:
    """Return the metadata in the bytes of a file, as `read_image_metadata` does; errors call it ``name``."""
    with _opened(data, name) as picture:
        text = getattr(picture, "text", {}).get(METADATA, "{}")
    try:
        metadata = json.loads(text)
    except ValueError as error:
        raise DataError(name, f"its {METADATA!r} text is not JSON: {error}") from error
    return dict(metadata)


def decode_image(
    data: bytes, *, name: str, mm_per_pixel: float | None = None, width_mm: float | None = None
) -> Image:
    """Return the photograph in the bytes of a file, as `read_image` does; errors call it ``name``."""
    if mm_per_pixel is not None and width_mm is not None:
        raise ParameterError("give mm_per_pixel or width_mm, got both")
    if width_mm is not None and not 0 < width_mm < np.inf:
        raise ParameterError.must("width_mm", "be > 0", width_mm)
    with decoding(name, NOT_READABLE), _opened(data, name) as picture:
        pixels = _pixels(ImageOps.exif_transpose(picture), name)
    if width_mm is not None:
        mm_per_pixel = width_mm / pixels.shape[1]
    return Image(pixels, mm_per_pixel)


def picture_size(data: bytes, *, name: str) -> tuple[int, int]:
    """Return rows and columns of the upright picture in ``data``; a JPEG is not unpacked for it."""
    with decoding(name, NOT_READABLE), _opened(data, name) as picture:
        columns, rows = picture.size
        turned = picture.getexif().get(EXIF_ORIENTATION, 1) in (5, 6, 7, 8)
    return (columns, rows) if turned else (rows, columns)


def picture_bytes(path: Path | str) -> bytes:
    """Return the content of a picture file; `DataError` if it is unreadable or empty."""
    if not (data := read_bytes(Path(path))):
        raise DataError(path, f"{NOT_READABLE}: empty file")
    return data


def is_plain(data: bytes, *, name: str) -> bool:
    """Return whether ``data`` needs no conversion but unpacking: upright 8-bit RGB or grey in PNG, JPEG or WebP."""
    with _opened(data, name) as picture:
        turned = picture.getexif().get(EXIF_ORIENTATION, 1) != 1
        known = picture.format in ("PNG", "JPEG", "WEBP") and picture.mode in ("RGB", "L")
    return known and not turned and "transparency" not in picture.info


def _opened(data: bytes, name: str) -> Pillow.Image:
    """Return the picture, of which only the header has been read, if its size is allowed."""
    formats: tuple[str, ...] = PICTURE_FORMATS[:-1]
    if data[4:8] == b"ftyp" and data[8:12] in HEIF_BRANDS:
        imported("pillow_heif", extra="formats", what=f"{name} (HEIC)").register_heif_opener()
        formats = PICTURE_FORMATS[-1:]
    with decoding(name, NOT_READABLE), warnings.catch_warnings():
        # Pillow warns of large pictures, which `MOST_PIXELS` refuses.
        warnings.simplefilter("ignore", Pillow.DecompressionBombWarning)
        try:
            picture = Pillow.open(io.BytesIO(data), formats=formats)
        except UnidentifiedImageError as error:
            raise DataError(
                name, f"{NOT_READABLE}: expected one of {', '.join(PICTURE_FORMATS)}; save it as PNG or JPEG"
            ) from error
        except Pillow.DecompressionBombError as error:
            raise DataError(name, _too_large()) from error
    columns, rows = picture.size
    if rows * columns > MOST_PIXELS:
        picture.close()
        raise DataError(name, f"{_too_large()}, got {columns} x {rows}")
    return picture


def _pixels(picture: Pillow.Image, name: str) -> NDArray[np.uint8]:
    """Return uint8 sRGB pixels, shape (row, column, 3)."""
    mode = picture.mode
    if mode.startswith("I"):
        values = np.asarray(picture).astype(np.int64)
        if values.min() < 0 or values.max() > 0xFFFF:
            raise DataError(
                name,
                f"pixels must have at most 16 bits, got {values.min()} to {values.max()}; save it as PNG",
            )
        # 65535 / 257 is 255. Pillow's own conversion would clip at 255 instead.
        grey = ((values + 128) // 257).astype(np.uint8)
        return np.repeat(grey[..., None], 3, axis=2)
    if mode == "F":
        raise DataError(name, "floating-point pixels have no agreed white; save it with 8 or 16 bits")
    if mode in ("RGBA", "LA", "PA", "RGBa", "La") or "transparency" in picture.info:
        picture = picture.convert("RGBA")
        page = Pillow.new("RGBA", picture.size, (255, 255, 255, 255))
        picture = Pillow.alpha_composite(page, picture)
    return np.asarray(picture.convert("RGB"), dtype=np.uint8)


def _too_large() -> str:
    return f"a picture must have at most {MOST_PIXELS} pixels (8192 x 8192); scale it down or cut it"
