"""Parts of what is sent: Safari plays an `<audio>` element only from a server that answers with the bytes asked for."""

from __future__ import annotations

import re

from fastapi import Response

_RANGE = re.compile(r"bytes=(\d{0,15})-(\d{0,15})")


def answer_of(data: bytes, asked: str | None, *, kind: str, headers: dict[str, str]) -> Response:
    """Return what is asked for of ``data``: all, one range of bytes, or a refusal (RFC 9110, section 14).

    Parameters
    ----------
    data : bytes
    asked : str, optional
        The request's header ``range``. What is malformed, or more than one range, is answered with all.
    kind : str
        Media type.
    headers : dict of str to str
        To be sent as well.
    """
    headers = headers | {"accept-ranges": "bytes"}
    found = _RANGE.fullmatch((asked or "").strip())
    first, last = found.groups() if found else ("", "")
    if not (first or last) or (first and last and int(first) > int(last)):
        return Response(data, media_type=kind, headers=headers)
    start = int(first) if first else max(0, len(data) - int(last))
    stop = min(len(data), int(last) + 1) if first and last else len(data)
    if start >= stop:
        return Response(status_code=416, headers=headers | {"content-range": f"bytes */{len(data)}"})
    headers["content-range"] = f"bytes {start}-{stop - 1}/{len(data)}"
    return Response(data[start:stop], status_code=206, media_type=kind, headers=headers)
