"""Secrets of a session: the key in the join address, and a ticket for each participant.

Both come from a file in the session's folder that only its owner can read. A ticket is a keyed hash of the
participant's code (HMAC-SHA-256, truncated to 192 bits): it cannot be guessed, reveals neither code nor session, and
survives a restart. Whoever has the folder has the tickets.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import os
import secrets
from dataclasses import dataclass
from pathlib import Path

from tactogram.errors import DataError
from tactogram.signal.io import atomic_write
from tactogram.text_files import read_json
from tactogram_study.session.participants import DIGITS, LETTERS, PAIRS

FILE = "keys.json"
TICKET_BYTES = 24
SHORTEST = 16
_NEW_KEYS = "delete the file to create new keys (links sent earlier stop working)"


@dataclass(frozen=True)
class SessionKeys:
    """Join key (part of the join address) and ticket secret of one session."""

    join: str
    secret: bytes

    def ticket(self, code: str) -> str:
        """Return the ticket of a participant; upper and lower case in the code are equal."""
        mac = self._mac("ticket", code.casefold())[:TICKET_BYTES]
        return base64.urlsafe_b64encode(mac).decode().rstrip("=")

    def code(self, attempt: str, count: int = 0) -> str:
        """Return the ``count``-th code for an attempt to join, the same whenever it is sent."""
        drawn = self._mac(f"code {count}", attempt)
        pairs = [(drawn[2 * i] % len(LETTERS), drawn[2 * i + 1] % len(DIGITS)) for i in range(PAIRS)]
        return "".join(LETTERS[letter] + DIGITS[digit] for letter, digit in pairs)

    def _mac(self, purpose: str, text: str) -> bytes:
        return hmac.digest(self.secret, f"{purpose}\0{text}".encode(), hashlib.sha256)


def load_keys(folder: Path) -> SessionKeys:
    """Return the keys of a session's folder, creating them on first use.

    Raises `DataError` if the folder is missing or not writable, or the key file is damaged.
    """
    path = folder / FILE
    try:
        if not path.is_file():
            drawn = {"join": secrets.token_urlsafe(16), "secret": secrets.token_hex(32)}
            write_secret(path, json.dumps(drawn).encode())
        if path.stat().st_mode & 0o077:
            path.chmod(0o600)
    except OSError as error:
        raise DataError(path, f"the session's keys cannot be read or created: {error.strerror}") from error
    try:
        values = read_json(path)
        keys = SessionKeys(str(values["join"]), bytes.fromhex(values["secret"]))
    except DataError as error:
        raise DataError(f"{error}; restore the session's keys, or {_NEW_KEYS}") from None
    except (ValueError, KeyError, TypeError):
        raise DataError(path, f"damaged session keys; restore the file, or {_NEW_KEYS}") from None
    if len(keys.join) < SHORTEST or len(keys.secret) < SHORTEST:
        raise DataError(path, f"the session's keys are too short to be secret; {_NEW_KEYS}")
    return keys


def write_secret(path: Path, data: bytes, *, replace: bool = False) -> None:
    """Write a file that its owner alone can read, and its folder, atomically.

    An existing file stays unless ``replace``: another process was first.
    """
    with atomic_write(path, durable=True, over=replace) as part:
        opened = os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        with os.fdopen(opened, "wb") as file:
            file.write(data)
