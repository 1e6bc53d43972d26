"""Secrets of a session: the key that lets people join, and a ticket for each participant.

Both come from a file in the session's folder that only its owner reads. A ticket is a keyed hash of the participant's
code (HMAC-SHA-256, 192 bits of it): it cannot be guessed, says nothing of code or session, and is the same after a
restart. Whoever has the folder has the tickets.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import secrets
from dataclasses import dataclass
from pathlib import Path

from tactogram.errors import DataError
from tactogram.studio.server.secret_files import write_secret
from tactogram.study.session.participants import DIGITS, LETTERS

FILE = "keys.json"
TICKET_BYTES = 24


@dataclass(frozen=True)
class SessionKeys:
    """The secrets of one session.

    Parameters
    ----------
    join : str
        Stands in the address by which people join.
    secret : bytes
        That tickets are made with.
    """

    join: str
    secret: bytes

    def ticket(self, code: str) -> str:
        """Return the ticket of a participant, whatever the case of the code's letters."""
        return _text(self._mac("ticket", code.casefold())[:TICKET_BYTES])

    def code(self, attempt: str, count: int = 0) -> str:
        """Return the ``count``-th code for an attempt to join: sent twice, it is the same."""
        drawn = self._mac(f"code {count}", attempt)
        pairs = [(drawn[2 * i] % len(LETTERS), drawn[2 * i + 1] % len(DIGITS)) for i in range(3)]
        return "".join(LETTERS[letter] + DIGITS[digit] for letter, digit in pairs)

    def _mac(self, purpose: str, text: str) -> bytes:
        return hmac.new(self.secret, f"{purpose}\0{text}".encode(), hashlib.sha256).digest()


def keys_of(folder: Path) -> SessionKeys:
    """Return the keys of a session's folder; they are drawn when there are none.

    Raises
    ------
    DataError
        If the folder is not there or cannot be written to, or its file of keys is damaged.
    """
    path = folder / FILE
    try:
        if not path.is_file():
            drawn = {"join": secrets.token_urlsafe(16), "secret": secrets.token_hex(32)}
            write_secret(path, json.dumps(drawn).encode())
        if path.stat().st_mode & 0o077:
            path.chmod(0o600)
        values = json.loads(path.read_text(encoding="ascii"))
        keys = SessionKeys(str(values["join"]), bytes.fromhex(values["secret"]))
    except OSError as error:
        raise DataError(f"{path}: keys can neither be read nor made: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(
            f"{path}: damaged keys; put back the file, or delete it to draw new ones (old links end)"
        ) from error
    if len(keys.join) < 16 or len(keys.secret) < 16:
        raise DataError(
            f"{path}: keys are too short to be secret; delete the file to draw new ones (old links end)"
        )
    return keys


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).decode().rstrip("=")
