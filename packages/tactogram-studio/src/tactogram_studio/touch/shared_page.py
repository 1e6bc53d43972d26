"""Textures of the page Touch as one HTML file, which anybody can open and pass on."""

from __future__ import annotations

import base64
import html
import json
from dataclasses import dataclass
from importlib.metadata import version
from string import Template
from typing import Any

from tactogram.errors import ParameterError
from tactogram.validation import validated
from tactogram_studio.touch.bundling import STATIC, bundled
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.sources import TextureRequest, TouchSources

RATE = 48_000.0
"""Rate at which a shared page plays, Hz; browsers resample it to the device's."""
MOST = 4
KEY = ("where", "of", "material")
PAGE = Template((STATIC / "touch_shared.html").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class SharedPage:
    """A page of its own, and a name for its file."""

    file_name: str
    html: str


def shared_page(rows: str, sources: TouchSources) -> SharedPage:
    """Return a page with the textures of ``rows``, which needs neither a server nor a network.

    ``rows`` is the state of the page Touch as JSON: ``arrangement``, and ``rows`` with ``key`` (where, of and material,
    as JSON), ``lay``, ``speed`` and ``weight``. Errors as of `TouchSources.table`; `ParameterError` for another state.
    """
    state, requests = _parsed(rows)
    offers, textures = [], {}
    simulated = False
    for request in requests:
        table, picture = sources.table(request), picture_of(sources, request)
        key = [request.where, request.of, request.material]
        simulated |= bool(table.head["simulated"])
        offers.append(dict(zip(KEY, key, strict=True)) | {"title": table.head["name"], "group": "Textures"})
        textures[_json(key)] = {
            "table": _part(table.packed()),
            "picture": _part(picture.webp, picture.headers()),
        }
    names = " and ".join(dict.fromkeys(str(offer["title"]) for offer in offers))
    return SharedPage(
        f"touch {names}.html".replace("/", "-"),
        _page(
            f"Touch {names}",
            state,
            {"rate": RATE, "offers": offers, "textures": textures},
            simulated=simulated,
        ),
    )


def _parsed(rows: str) -> tuple[dict[str, Any], list[TextureRequest]]:
    try:
        state = json.loads(rows)
        requests = [_request(row) for row in state["rows"]]
    except (ValueError, TypeError, KeyError) as error:
        raise ParameterError("open the page Touch again: its state could not be read") from error
    if not 1 <= len(requests) <= MOST:
        raise ParameterError(f"share 1 to {MOST} textures at a time, got {len(requests)}")
    return {"rows": state["rows"], "arrangement": state.get("arrangement")}, requests


def _request(row: dict[str, Any]) -> TextureRequest:
    where, of, material = json.loads(row["key"])
    values = {"where": where, "of": of, "material": material, "lay": row["lay"], "rate": RATE}
    return validated(TextureRequest, values | {"speed_mm_s": row["speed"]}, where="")


def _json(value: Any) -> str:
    """Return JSON as JavaScript writes it, safe within a script element."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _part(content: bytes, headers: dict[str, str] | None = None) -> dict[str, Any]:
    return {"bytes": base64.b64encode(content).decode(), "headers": headers or {}}


def _page(title: str, state: dict[str, Any], held: dict[str, Any], *, simulated: bool) -> str:
    styles = "".join((STATIC / name).read_text(encoding="utf-8") for name in ("studio.css", "touch.css"))
    note = "What is felt here is simulated. " if simulated else ""
    return PAGE.substitute(
        title=html.escape(title),
        styles=styles,
        markup=(STATIC / "touch.html").read_text(encoding="utf-8"),
        note=f"{note}Made with tactogram {version('tactogram')}. This file needs no network, and sends nothing.",
        settings=_json({"rows": state}),
        held=_json(held),
        script=bundled(STATIC / "touch.js"),
    )
