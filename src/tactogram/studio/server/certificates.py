"""Certificates for https: one of our own, signed by itself and kept, or a laboratory's.

Browsers give AudioWorklet, camera and clipboard to secure contexts only (W3C Secure Contexts): this machine itself, or
a page that came encrypted, also where somebody had to confirm the certificate.
"""

from __future__ import annotations

import ipaddress
import re
import socket
import ssl
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from tactogram.errors import DataError
from tactogram.extras import imported
from tactogram.studio.server.secret_files import write_secret

if TYPE_CHECKING:
    from cryptography.x509 import Certificate as Parsed
    from cryptography.x509 import GeneralName

VALID = timedelta(days=397)
"""Of our own. Browsers of Apple's refuse more than 825 days (support.apple.com/103769); 398 are for authorities'."""
LEFT = timedelta(days=7)
"""With less than this before it a new one is made, so that none ends in the midst of a study."""
_NAME = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


@dataclass(frozen=True)
class Certificate:
    """A certificate and its key.

    Parameters
    ----------
    file, key : Path
        As PEM; may be the same file.
    names : tuple of str
        Names and addresses that it holds for.
    until : datetime
    sha256 : str
        Its fingerprint as browsers show it: 32 bytes in hexadecimal, with colons.
    own : bool
        Whether it was made here and signed by itself, so that browsers ask before they trust it.
    """

    file: Path
    key: Path
    names: tuple[str, ...]
    until: datetime
    sha256: str
    own: bool

    def context(self) -> ssl.SSLContext:
        """Return the server's side of TLS, 1.2 or later, with this certificate.

        Raises
        ------
        DataError
            If it is too weak for TLS.
        """
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.set_alpn_protocols(["http/1.1"])
        try:
            context.load_cert_chain(self.file, self.key, password="")
        except ssl.SSLError as error:
            why = (error.reason or str(error)).lower().replace("_", " ")
            raise DataError(f"{self.file}: cannot be used for TLS ({why}); make another") from None
        return context


def given_certificate(file: Path, key: Path, *, now: datetime | None = None) -> Certificate:
    """Return a laboratory's certificate.

    Parameters
    ----------
    file : Path
        The server's certificate first, then those that it follows from.
    key : Path
        Without a password.
    now : datetime, optional

    Raises
    ------
    DataError
        If a file is missing, is none, is locked, has run out, or does not belong to the other.
    """
    imported("cryptography", extra="studio", what="certificates")
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    parsed = _parsed(file, _read(file, "certificate"))
    secret = _read(key, "key")
    try:
        opened = load_pem_private_key(secret, password=None)
    except TypeError:
        raise DataError(f"{key}: is locked by a password; give a key without one") from None
    except Exception as error:  # of several kinds, by what is wrong in it
        raise DataError(f"{key}: holds no private key as PEM; give the key of {file} by --key") from error
    if opened.public_key() != parsed.public_key():
        raise DataError(f"{key}: is not the key of {file}; give the two that were made together")
    now = now or datetime.now(UTC)
    if not parsed.not_valid_before_utc <= now <= parsed.not_valid_after_utc:
        since, until = parsed.not_valid_before_utc, parsed.not_valid_after_utc
        raise DataError(f"{file}: holds from {since:%Y-%m-%d} to {until:%Y-%m-%d}, not now; have it renewed")
    found = _certificate(parsed, file, key, own=False)
    found.context()
    return found


def kept_certificate(path: Path, names: Sequence[str], *, now: datetime | None = None) -> Certificate:
    """Return the certificate that is kept in a file, or a new one, where none is kept that holds for all ``names``.

    Parameters
    ----------
    path : Path
        PEM of key and certificate, readable by its owner only.
    names : sequence of str
        Names and addresses of this machine.
    now : datetime, optional

    Raises
    ------
    DataError
        If it can neither be read nor made.
    """
    imported("cryptography", extra="studio", what="certificates")
    now = now or datetime.now(UTC)
    wanted = {str(held.value) for name in names if (held := _held(name))}
    try:
        if path.is_file():
            if path.stat().st_mode & 0o077:
                path.chmod(0o600)
            try:
                kept = _certificate(_parsed(path, path.read_bytes()), path, path, own=True)
                kept.context()
            except DataError:  # damaged: a new one is as good
                kept = None
            if kept is not None and wanted <= set(kept.names) and now + LEFT <= kept.until:
                return kept
        _make(path, names, now)
        return _certificate(_parsed(path, path.read_bytes()), path, path, own=True)
    except OSError as error:
        raise DataError(f"{path}: the certificate can neither be read nor made: {error.strerror}") from error


def _make(path: Path, names: Sequence[str], now: datetime) -> None:
    """Write a new key and its certificate."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name(
        [x509.NameAttribute(x509.NameOID.COMMON_NAME, f"tactogram on {socket.gethostname()}"[:64])]
    )
    held = x509.SubjectAlternativeName([value for text in dict.fromkeys(names) if (value := _held(text))])
    # No authority: a tablet that is made to trust it trusts this server, and no other in its name.
    constraints = x509.BasicConstraints(ca=False, path_length=None)
    signs_handshakes = x509.KeyUsage(True, *[False] * 8)  # and nothing else
    purpose = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
    certificate = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))  # a tablet's clock may be late
        .not_valid_after(now + VALID)
        .add_extension(held, critical=False)
        .add_extension(constraints, critical=True)
        .add_extension(signs_handshakes, critical=True)
        .add_extension(purpose, critical=False)
        .sign(key, hashes.SHA256())
    )
    pem, plain = serialization.Encoding.PEM, serialization.NoEncryption()
    written = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, plain) + certificate.public_bytes(pem)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_secret(path, written, over=True)


def _read(path: Path, what: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise DataError(f"{path}: there is no such file; give the {what} as PEM") from None
    except OSError as error:
        raise DataError(f"{path}: the {what} cannot be read: {error.strerror}") from None


def _parsed(path: Path, pem: bytes) -> Parsed:
    from cryptography import x509

    try:
        return x509.load_pem_x509_certificates(pem)[0]
    except ValueError:
        raise DataError(f"{path}: holds no certificate as PEM (-----BEGIN CERTIFICATE-----)") from None


def _certificate(parsed: Parsed, file: Path, key: Path, *, own: bool) -> Certificate:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes

    try:
        held = parsed.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, ValueError):
        held = x509.SubjectAlternativeName([])
    named = [_as_here(name) for name in held.get_values_for_type(x509.DNSName)]
    numbers = [str(number) for number in held.get_values_for_type(x509.IPAddress)]
    return Certificate(
        file=file,
        key=key,
        names=(*named, *numbers),
        until=parsed.not_valid_after_utc,
        sha256=parsed.fingerprint(hashes.SHA256()).hex(":").upper(),
        own=own,
    )


def _as_here(name: str) -> str:
    """Return the name of this machine where a certificate holds for all names of a domain."""
    return name.replace("*", socket.gethostname().partition(".")[0], 1) if name.startswith("*.") else name


def _held(name: str) -> GeneralName | None:
    """Return a name or address as a certificate holds it; None if no host is called so."""
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name) if _NAME.fullmatch(name) else None
