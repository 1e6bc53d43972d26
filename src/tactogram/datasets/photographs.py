"""Photographs in a store: encoded once each, found by what they show."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image as Pillow
from PIL import ImageOps

from tactogram.errors import DataError
from tactogram.signal import Image

KEPT_FORMATS = ("PNG", "JPEG", "WEBP")


@dataclass(frozen=True)
class Photograph:
    """An encoded picture.

    Parameters
    ----------
    key : str
        16 hex digits that follow from the pixels and their scale, not from how they are encoded.
    data : bytes
        PNG, JPEG or WebP.
    mm_per_pixel : float, optional
    """

    key: str
    data: bytes
    mm_per_pixel: float | None = None


def image_key(image: Image) -> str:
    """Return 16 hex digits that follow from pixels and scale."""
    digest = hashlib.sha256(f"{image.pixels.shape}|{image.mm_per_pixel!r}|".encode())
    digest.update(image.pixels.tobytes())
    return digest.hexdigest()[:16]


def encode(image: Image) -> bytes:
    """Return ``image`` as PNG, without loss."""
    buffer = io.BytesIO()
    Pillow.fromarray(image.pixels).save(buffer, "PNG", compress_level=4)
    return buffer.getvalue()


def decode(
    data: bytes, *, mm_per_pixel: float | None = None, width_mm: float | None = None, name: str
) -> Image:
    """Return the picture in ``data``, turned as its EXIF tag says, as RGB.

    Parameters
    ----------
    data : bytes
    mm_per_pixel, width_mm : float, optional
        Its scale, either per pixel or for the whole width.
    name : str
        What to call it in errors.

    Raises
    ------
    DataError
        If it is not a picture.
    """
    try:
        with Pillow.open(io.BytesIO(data)) as picture:
            pixels = np.asarray(ImageOps.exif_transpose(picture).convert("RGB"), dtype=np.uint8)
    except (OSError, ValueError, SyntaxError, Pillow.DecompressionBombError) as error:
        raise DataError(f"{name}: not a readable picture: {error}") from error
    if width_mm is not None:
        mm_per_pixel = width_mm / pixels.shape[1]
    return Image(pixels, mm_per_pixel)


def read_photograph(path: Path, *, width_mm: float | None = None) -> Photograph:
    """Read a picture file; PNG, JPEG and WebP stay as they are, anything else becomes PNG.

    Raises
    ------
    DataError
        If it is not a picture.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DataError(f"{path}: not readable: {error.strerror}") from error
    image = decode(data, width_mm=width_mm, name=str(path))
    with Pillow.open(io.BytesIO(data)) as picture:
        kept = picture.format in KEPT_FORMATS
    return Photograph(image_key(image), data if kept else encode(image), image.mm_per_pixel)
