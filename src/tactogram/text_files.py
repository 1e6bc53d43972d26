"""Text files: settings in TOML, documents in JSON and tables in CSV, read within limits."""

from __future__ import annotations

import codecs
import csv
import io
import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, MissingExtraError, ParameterError

MOST_BYTES = 2**28
MOST_TOML_BYTES = 2**20
MOST_KEY_PARTS = 32
"""Parts of a dotted key in TOML, whose parsing time grows with their square."""
MOST_DEPTH = 32
"""Levels of nested tables and lists in TOML."""
_LONG_KEY = re.compile(
    rf"""(?<![\w.-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{MOST_KEY_PARTS}}}"""
)
_LONG_INTEGER = re.compile(r"\d{19}")

REPLACEMENT = "\ufffd"
"""Stands for a byte of a file name that is not UTF-8."""
_CLUES = {
    "cp932": re.compile("時間|加速度|速度|荷重|センサ|データ|[ぁ-ん]{2}"),
    "gb18030": re.compile("时间|加速度|数据|传感器|角速度"),
    "cp949": re.compile("시간|가속도|데이터|센서"),
    "cp1251": re.compile("[Вв]рем|[Уу]скор|[Сс]ила"),
}
"""Words that tell the encoding of a heading, which is too short for statistics."""
_SURROGATE = re.compile("[\ud800-\udfff]")


def path_of(value: object, parameter: str) -> Path:
    """Return an argument as a path; `ParameterError` if it is none, such as an array."""
    if not isinstance(value, str | PathLike):
        raise ParameterError.must(parameter, "be a path", value)
    return Path(value)


def check_regular(path: Path) -> None:
    """Refuse a missing file, a folder, and a pipe, socket or device, which would be read for ever."""
    if not path.is_file():
        kind = "is a folder" if path.is_dir() else "is no file on a disk; save it as one"
        raise DataError(path, kind if path.exists() else "no such file")


def displayable(text: str) -> str:
    """Return a text that can be shown and sent: bytes of file names that are not UTF-8 become `REPLACEMENT`."""
    return _SURROGATE.sub(REPLACEMENT, text)


def decode_text(
    raw: bytes, where: Path | str, *, encoding: str = "utf-8-sig", cut_short: bool = False
) -> str:
    """Return ``raw`` as text, `DataError` if it is not in this encoding; the last character may be ``cut_short``."""
    if encoding.startswith("utf-8") and (zero := raw.find(b"\0")) >= 0:
        raise DataError(where, f"not a text file: zero byte at byte {zero}; save it as UTF-8")
    try:
        return raw.decode(encoding, "ignore" if cut_short else "strict")
    except UnicodeDecodeError as error:
        name = "UTF-8" if encoding == "utf-8-sig" else encoding
        got = f"got the byte {raw[error.start]:#04x}"
        raise DataError(where, f"not {name} text at byte {error.start}, {got}; save it as UTF-8") from None


def detected_text(raw: bytes, where: Path | str) -> tuple[str, str]:
    """Return ``raw`` as text, and its encoding: UTF-8 and UTF-16 are certain, others detected.

    Single bytes beyond ASCII are Western European (cp1252), as Excel and LabVIEW write them; runs of them are left to
    charset-normalizer, which needs more than a few letters. A `DataError` if it is no text.
    """
    for mark, encoding in ((codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")):
        if raw.startswith(mark):
            return raw.decode(encoding, "replace"), encoding
    odd, even = raw[1:4096:2].count(0), raw[:4096:2].count(0)
    if max(odd, even) > 0.4 * len(raw[:4096:2]) and min(odd, even) * 10 < max(odd, even):
        encoding = "utf-16-be" if even > odd else "utf-16-le"
        return raw.decode(encoding, "replace"), encoding
    if b"\0" in raw:
        return decode_text(raw, where), "utf-8"  # raises
    try:
        return raw.decode("utf-8-sig"), "utf-8"
    except UnicodeDecodeError as error:
        if error.reason == "unexpected end of data" and error.end == len(raw):
            return raw.decode("utf-8-sig", "ignore"), "utf-8"
    encoding = next(
        (name for name, form in _CLUES.items() if form.search(raw.decode(name, "ignore"))), "cp1252"
    )
    run = re.search(rb"[\x80-\xff]{3}", raw) if encoding == "cp1252" else None
    if run is not None:
        try:
            from charset_normalizer import from_bytes
        except ImportError as error:
            raise MissingExtraError(
                f"{where}: text that is neither UTF-8 nor Western European needs charset-normalizer; install the extra "
                "formats: pip install 'tactogram[formats]'"
            ) from error
        lines = raw[max(0, run.start() - 2048) : run.start() + 4096]
        best = from_bytes(lines, cp_isolation=["cp932", "gb18030", "cp949", "big5", "cp1251"]).best()
        encoding = encoding if best is None else best.encoding
    return raw.decode(encoding, "replace"), encoding


def read_text(path: Path, *, encoding: str = "utf-8-sig", most_bytes: int = MOST_BYTES) -> str:
    """Return the text in a file.

    Raises `DataError` if it is unreadable, larger than ``most_bytes``, or not text in this encoding.
    """
    return decode_text(read_bytes(path, most_bytes), path, encoding=encoding)


def read_bytes(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Return the content of a file; `DataError` if it is unreadable, or larger than ``most_bytes``."""
    try:
        check_regular(path)
        with path.open("rb") as file:
            raw = file.read(most_bytes + 1)
    except (OSError, ValueError) as error:
        raise DataError(path, f"not readable: {getattr(error, 'strerror', None) or error}") from error
    if len(raw) > most_bytes:
        raise DataError(path, f"must have at most {most_bytes} bytes, got more")
    return raw


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; errors as `read_text` and `parse_toml`."""
    return parse_toml(read_text(path, most_bytes=MOST_TOML_BYTES), path)


def parse_toml(text: str, where: Path | str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises `DataError` if it is not TOML, exceeds `MOST_KEY_PARTS` or `MOST_DEPTH`, or holds an integer of more than 64
    bits, which the format excludes.
    """
    if _LONG_KEY.search(text):
        raise DataError(where, f"a key must have at most {MOST_KEY_PARTS} parts")
    try:
        values = tomllib.loads(text)
        _check_values(values, MOST_DEPTH)
    except (ValueError, RecursionError) as error:
        raise DataError(where, f"not readable as TOML: {_reason(error)}") from None
    return values


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; errors as `read_text` and `parse_json`."""
    return parse_json(read_text(path), path)


def parse_json(text: str, where: Path | str, *, finite: bool = False) -> Any:
    """Return the content of a JSON text; ``finite`` refuses NaN, infinity and integers of more than 64 bits.

    Raises `DataError` if it is not JSON, or nested too deep.
    """
    hooks: dict[str, Any] = {"parse_constant": _refused} if finite else {}
    if finite and _LONG_INTEGER.search(text):  # only then: a hook for every integer is slow
        hooks["parse_int"] = _int64
    try:
        return json.loads(text, **hooks)
    except (ValueError, RecursionError) as error:
        raise DataError(where, f"not a JSON document: {_reason(error)}") from None


def finite_json(value: Any) -> Any:
    """Return values for JSON, which has no NaN and no infinity: None stands for them."""
    if isinstance(value, Mapping):
        return {str(name): finite_json(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [finite_json(inner) for inner in value]
    if hasattr(value, "item"):  # a number of NumPy's
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def csv_rows(text: str, where: Path | str, *, delimiter: str = ",") -> list[tuple[int, list[str]]]:
    """Return the rows that hold a cell, each with its number as in a spreadsheet.

    Raises `DataError` if a quote is left open, or a cell exceeds the csv module's limit.
    """
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        return [(number, row) for number, row in enumerate(reader, 1) if row]
    except csv.Error as error:
        reason = f"{error}; is a quote left open?" if "limit" in str(error) else error
        raise DataError(where, f"not a table: {reason} (line {reader.line_num})") from None


def read_table(path: Path, *, needed: Sequence[str] = ()) -> list[tuple[int, dict[str, str]]]:
    """Return the rows of a CSV file by heading, each with its number as in a spreadsheet; missing last cells are empty.

    Raises `DataError` as `read_text` and `csv_rows`; if one of the columns ``needed`` is missing, or a row has too many
    cells.
    """
    (_, headings), *rows = csv_rows(read_text(path), path) or [(1, [])]
    if missing := [name for name in needed if name not in headings]:
        raise DataError(
            path, f"needs columns {', '.join(needed)}, lacks {', '.join(missing)}, has {', '.join(headings)}"
        )
    for number, row in rows:
        if len(row) > len(headings):
            raise DataError(path, f"row {number} has more values than there are columns")
    return [
        (number, dict(zip(headings, row + [""] * (len(headings) - len(row)), strict=True)))
        for number, row in rows
    ]


def _check_values(value: Any, depth: int) -> None:
    if not depth:
        raise ValueError(f"nested deeper than {MOST_DEPTH}")
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            _check_values(inner, depth - 1)
    elif isinstance(value, int):
        _int64(value)


def _int64(number: int | str) -> int:
    value = int(number)
    if value.bit_length() > 63:
        raise ValueError(f"an integer must have at most 64 bits, got {value.bit_length() + 1}")
    return value


def _refused(name: str) -> Any:
    raise ValueError(f"{name} is not a JSON number")


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return "nested too deep"
    if "integer string conversion" in str(error):
        return "an integer must have at most 64 bits, got thousands of digits"
    return str(error)
