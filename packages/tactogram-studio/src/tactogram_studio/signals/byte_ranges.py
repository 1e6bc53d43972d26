"""Byte ranges of responses: Safari plays an `<audio>` element only from a server that supports them."""

from __future__ import annotations

import re

from fastapi import Response

_RANGE = re.compile(r"bytes=(\d{0,15})-(\d{0,15})")


def range_response(
    data: bytes, requested: str | None, *, media_type: str, headers: dict[str, str]
) -> Response:
    """Return ``data``, one range of its bytes, or a refusal (RFC 9110, section 14).

    ``requested`` is the request's ``range`` header; if it is malformed or names several ranges, all bytes are sent.
    """
    headers = headers | {"accept-ranges": "bytes"}
    match = _RANGE.fullmatch((requested or "").strip())
    first, last = match.groups() if match else ("", "")
    if not (first or last) or (first and last and int(first) > int(last)):
        return Response(data, media_type=media_type, headers=headers)
    start = int(first) if first else max(0, len(data) - int(last))
    stop = min(len(data), int(last) + 1) if first and last else len(data)
    if start >= stop:
        return Response(status_code=416, headers=headers | {"content-range": f"bytes */{len(data)}"})
    headers["content-range"] = f"bytes {start}-{stop - 1}/{len(data)}"
    return Response(data[start:stop], status_code=206, media_type=media_type, headers=headers)
