"""Photographs in a store: encoded once each, found by what they show."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

from PIL import Image as Pillow

from tactogram.signal import Image
from tactogram.signal.io.picture import decode_image, is_plain, picture_bytes

PICTURES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff")
"""Suffixes of files that are looked at as photographs."""


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


def read_photograph(
    path: Path, *, mm_per_pixel: float | None = None, width_mm: float | None = None
) -> Photograph:
    """Read a picture file; what needs no conversion stays as it is, anything else becomes PNG.

    See `tactogram.signal.io.read_image` for what is converted and what is refused.

    Raises
    ------
    DataError
        If it is not a picture.
    """
    data = picture_bytes(path)
    image = decode_image(data, name=str(path), mm_per_pixel=mm_per_pixel, width_mm=width_mm)
    kept = data if is_plain(data, name=str(path)) else encode(image)
    return Photograph(image_key(image), kept, image.mm_per_pixel)


def photograph_of(image: Image) -> Photograph:
    """Return ``image`` encoded."""
    return Photograph(image_key(image), encode(image), image.mm_per_pixel)
