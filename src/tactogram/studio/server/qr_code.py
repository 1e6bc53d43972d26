"""QR codes of addresses, so that nobody types a token on a tablet."""

from __future__ import annotations

import io

from tactogram.extras import imported

_BLACK_AND_WHITE, _AS_BEFORE = "\x1b[40;97m", "\x1b[0m"


def svg_qr_code(address: str) -> str:
    """Return an address as a QR code, SVG as the source of an ``img``; its ``alt`` is to be given there."""
    segno = imported("segno", extra="studio", what="QR codes")
    return str(segno.make_qr(address, error="m").svg_data_uri(scale=4, light="#fff"))


def terminal_qr_code(address: str, columns: int) -> str:
    """Return an address as a QR code of half blocks, dark on light whatever the colours are; "" where there is no room.

    Parameters
    ----------
    address : str
    columns : int
        Characters in a line of the terminal.
    """
    segno = imported("segno", extra="studio", what="QR codes")
    # No more correction than needed: each step makes it larger, and a screen has no scratches.
    code = segno.make_qr(address, error="l")
    if code.symbol_size()[0] > columns:
        return ""
    drawn = io.StringIO()
    code.terminal(drawn, compact=True)
    return "\n".join(f"{_BLACK_AND_WHITE}{line}{_AS_BEFORE}" for line in drawn.getvalue().splitlines())
