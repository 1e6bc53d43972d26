"""QR codes of addresses, so that nobody types a token on a tablet."""

from __future__ import annotations

import io

from tactogram.extras import imported

_BLACK_AND_WHITE, _RESET = "\x1b[40;97m", "\x1b[0m"


def svg_qr_code(address: str) -> str:
    """Return a QR code as an SVG data URI for the ``src`` of an ``img``."""
    segno = imported("segno", extra="studio", what="QR codes")
    return str(segno.make_qr(address, error="m").svg_data_uri(scale=4, light="#fff"))


def terminal_qr_code(address: str, columns: int) -> str:
    """Return a QR code of half blocks, dark on light in any colour scheme; "" if wider than ``columns``."""
    segno = imported("segno", extra="studio", what="QR codes")
    # Low error correction: each level makes the code larger, and a screen has no scratches.
    code = segno.make_qr(address, error="l")
    if code.symbol_size()[0] > columns:
        return ""
    drawn = io.StringIO()
    code.terminal(drawn, compact=True)
    return "\n".join(f"{_BLACK_AND_WHITE}{line}{_RESET}" for line in drawn.getvalue().splitlines())
