"""Seeded damage to a file: bytes, words, numbers, keys and values, and what is packed inside."""

from __future__ import annotations

import bz2
import gzip
import io
import json
import lzma
import re
import struct
import tomllib
import zipfile
from collections.abc import Callable
from random import Random
from typing import Any

import tomli_w

BITS = tuple(struct.pack(form, value) for form, value in (
    ("<i", -1), ("<i", 2**31 - 1), ("<q", 2**62), ("<d", 1e308), ("<d", float("nan")), ("<f", float("inf")),
    ("<I", 10**9), (">I", 10**9), ("<q", 0), ("<H", 0xFFFF),
))  # fmt: skip
NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-308",
    str(2**63),
    "1e9",
    "1e6",
    "1e15",
    "1e9999",
)
TOKENS = (
    *NUMBERS,
    "",
    "x",
    '"',
    "1,5",
    "0x10",
    "-0.0",
    "true",
    "null",
    "\0",
    "\u202e",
    "\U0001f600",
    "9" * 5000,
)
EXTREMES = (-1, 0, 2, 0.5, 1e308, -1e308, 1e-308, 2**31, 2**63, 10**15, 1e9, 1e6, float("nan"), float("inf"))
TEXTS = ("", "x", "\0", "nan", "x" * 300, "../../x", "/dev/zero", "a/b", "\u202e")
VALUES: tuple[Any, ...] = (
    None,
    True,
    False,
    *EXTREMES,
    *TEXTS,
    [],
    {},
    [[]],
    [{}],
    [None],
    {"x": {}},
    [1, "x"],
)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
WORD = re.compile(r"[^\s,;:=]+")


def damaged(raw: bytes, name: str, rng: Random) -> bytes:
    """Return a file's content, damaged at least once in a way that suits its name."""
    suffix = name.rpartition(".")[2].lower()
    kinds: list[Callable[[bytes, str, Random], bytes]] = [_bytes]
    if suffix in PACKERS or suffix in ("zip", "npz", "xlsx"):
        kinds += [_packed] * 2
    elif suffix in ("json", "ahap", "haps", "haptic", "hjif", "tact", "toml", "jsonl"):
        kinds += [_tree] * 4 + [_text]
    elif b"\0" not in raw:
        kinds += [_text] * 3
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        raw = rng.choice(kinds)(raw, name, rng)
    return raw


def _bytes(raw: bytes, name: str, rng: Random) -> bytes:
    size = len(raw)
    # Headers, and the ends where Parquet and archives have their directories, are short and matter most.
    at = rng.choice(
        (rng.randint(0, size), rng.randint(0, min(size, 128)), max(0, size - rng.randint(0, 256)))
    )
    length = rng.choice((1, 4, 16, 256, size // 4))
    match rng.randrange(9):
        case 0 | 1 | 2:
            data = bytearray(raw)
            for _ in range(rng.choice((1, 1, 4, 16)) if size else 0):
                place = min(size - 1, max(0, at + rng.randint(-64, 64)))
                data[place] ^= 1 << rng.randrange(8)
            return bytes(data)
        case 3:
            return raw[:at]
        case 4:
            return raw[:at] + raw[at + length :]
        case 5:
            return raw[: at + length] + raw[at : at + length] * rng.choice((1, 1, 50)) + raw[at + length :]
        case 6:
            block = rng.choice(BITS)
            return raw[:at] + block + raw[at + len(block) :]
        case 7:
            return rng.choice(
                (b"", b"\0" * size, raw.decode("latin-1").encode("utf-16"), b"\xff" * 64, b"\n", raw * 3)
            )
        case _:
            return raw[:at] + rng.choice((b"\0", b"\xef\xbb\xbf", b"\r", b"\x1a", b"\xe9")) + raw[at:]


def _text(raw: bytes, name: str, rng: Random) -> bytes:
    text = raw.decode("utf-8", "surrogateescape")
    lines, found = text.splitlines(keepends=True), list(rng.choice((NUMBER, NUMBER, WORD)).finditer(text))
    if len(lines) > 1 and rng.random() < 0.35:
        a, b = rng.randrange(len(lines)), rng.choice((0, rng.randrange(len(lines))))
        match rng.randrange(4):
            case 0:
                del lines[a]
            case 1:
                lines.insert(b, lines[a])
            case 2:
                lines[a], lines[b] = lines[b], lines[a]
            case _:
                lines[a] = lines[a].replace(",", rng.choice((";", "\t", ",,", " ")))
        text = "".join(lines)
    elif found:
        one = rng.choice(found)
        text = text[: one.start()] + rng.choice(TOKENS) + text[one.end() :]
    return text.encode("utf-8", "surrogateescape")


def _tree(raw: bytes, name: str, rng: Random) -> bytes:
    """Damage one value of a document, if it is one."""
    toml, lines = name.endswith(".toml"), name.endswith(".jsonl")
    try:
        if lines:
            tree: Any = [json.loads(line) for line in raw.decode().splitlines()]
        else:
            tree = tomllib.loads(raw.decode()) if toml else json.loads(raw)
    except (ValueError, RecursionError):
        return _text(raw, name, rng)
    # By depth: every level is met, not mainly the many values of the deepest.
    levels = _places(tree)
    holder, key = rng.choice(rng.choice(levels)) if levels else ([tree], 0)
    match rng.randrange(8):
        case 0 | 1:
            del holder[key]
        case 2 if isinstance(holder[key], int | float) and not isinstance(holder[key], bool):
            holder[key] *= rng.choice((1e9, -1, 1e-9, 1e300, 1000))
        case 3:
            other, place = rng.choice(rng.choice(levels)) if levels else ([tree], 0)
            holder[key], other[place] = other[place], holder[key]
        case 4:
            holder[key] = [holder[key]]
        case 5 if isinstance(holder, dict):
            holder[f"{key}x"] = holder.pop(key)
        case 5:
            holder[:] = holder * 50
        case _:
            holder[key] = rng.choice(VALUES)
    if not levels:
        tree = rng.choice(VALUES)
    try:
        if lines:
            return "".join(json.dumps(each) + "\n" for each in tree).encode()
        return tomli_w.dumps(tree).encode() if toml else json.dumps(tree).encode()
    except (TypeError, ValueError, AttributeError, RecursionError):
        return _text(raw, name, rng)


def _places(tree: Any) -> list[list[tuple[Any, Any]]]:
    levels, current = [], [tree]
    while current:
        level = [
            (holder, key)
            for holder in current
            if isinstance(holder, dict | list)
            for key in (list(holder) if isinstance(holder, dict) else range(len(holder)))
        ]
        current = [holder[key] for holder, key in level]
        levels += [level] if level else []
    return levels


PACKERS = {"gz": gzip, "bz2": bz2, "xz": lzma}


def _packed(raw: bytes, name: str, rng: Random) -> bytes:
    """Damage what is inside of a packed file."""
    inner, _, suffix = name.rpartition(".")
    try:
        if suffix in PACKERS:
            packer: Any = PACKERS[suffix]
            return packer.compress(damaged(packer.decompress(raw), inner, rng))
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            members = {each: archive.read(each) for each in archive.namelist()}
    except Exception:  # damaged before
        return _bytes(raw, name, rng)
    if members:
        chosen = rng.choice(list(members))
        if rng.random() < 0.15:
            del members[chosen]
        else:
            members[chosen] = damaged(members[chosen], chosen, rng)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for each, content in members.items():
            archive.writestr(each, content)
    return packed.getvalue()
