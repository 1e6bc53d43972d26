"""Certificates for https, signed by itself and kept in a file or the laboratory's own, and files of secrets.

Browsers allow AudioWorklet, camera and clipboard in secure contexts only (W3C Secure Contexts): pages of this machine
itself, or encrypted ones, even where the user had to accept the certificate.
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
from tactogram_study.participants.tickets import write_secret

if TYPE_CHECKING:
    from cryptography.x509 import Certificate as ParsedCertificate, GeneralName

VALIDITY = timedelta(days=397)
"""Of a self-signed certificate. Apple's browsers refuse more than 825 days (support.apple.com/103769)."""
RENEWAL = timedelta(days=7)
"""A self-signed certificate is replaced this long before its end, so that none expires during a study."""
_NAME = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)*")


@dataclass(frozen=True)
class Certificate:
    """A certificate and its key as PEM, maybe in one file.

    ``names`` are the host names and addresses that it covers; ``sha256`` is its fingerprint as browsers show it.
    Browsers ask before they trust a ``self_signed`` one.
    """

    file: Path
    key: Path
    names: tuple[str, ...]
    valid_until: datetime
    sha256: str
    self_signed: bool

    def context(self) -> ssl.SSLContext:
        """Return the server's side of TLS, 1.2 or later; `DataError` if the certificate is too weak."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.set_alpn_protocols(["http/1.1"])
        try:
            context.load_cert_chain(self.file, self.key, password="")
        except ssl.SSLError as error:
            reason = (error.reason or str(error)).lower().replace("_", " ")
            raise DataError(self.file, f"cannot be used for TLS ({reason}); make another") from None
        return context


def load_certificate(file: Path, key: Path, *, now: datetime | None = None) -> Certificate:
    """Return a laboratory's own certificate; ``file`` holds the server's certificate, followed by its chain.

    Raises `DataError` if a file is missing, damaged, expired or locked by a password, or the two do not match.
    """
    imported("cryptography", extra="studio", what="certificates")
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    parsed = _parsed(file, _read(file, "certificate"))
    secret = _read(key, "key")
    try:
        private_key = load_pem_private_key(secret, password=None)
    except TypeError:
        raise DataError(key, "is locked by a password; use a key without one") from None
    except Exception as error:  # of several kinds, depending on the damage
        raise DataError(key, f"not a private key in PEM format; name the key of {file}") from error
    if private_key.public_key() != parsed.public_key():
        raise DataError(key, f"is not the key of {file}; use the two that were made together")
    now = now or datetime.now(UTC)
    since, until = parsed.not_valid_before_utc, parsed.not_valid_after_utc
    if not since <= now <= until:
        raise DataError(file, f"valid from {since:%Y-%m-%d} to {until:%Y-%m-%d}, not now; renew it")
    certificate = _certificate(parsed, file, key, self_signed=False)
    certificate.context()
    return certificate


def self_signed_certificate(path: Path, names: Sequence[str], *, now: datetime | None = None) -> Certificate:
    """Return the certificate in a file, or a new one if it does not cover all ``names`` or is about to expire.

    The file holds the key, too, and is readable by its owner only.

    Raises `DataError` if it can neither be read nor created.
    """
    imported("cryptography", extra="studio", what="certificates")
    now = now or datetime.now(UTC)
    required = {str(entry.value) for name in names if (entry := _general_name(name))}
    try:
        if path.is_file():
            if path.stat().st_mode & 0o077:
                path.chmod(0o600)
            try:
                certificate = _certificate(_parsed(path, path.read_bytes()), path, path, self_signed=True)
                certificate.context()
            except DataError:  # damaged: a new one is as good
                pass
            else:
                if required <= set(certificate.names) and now + RENEWAL <= certificate.valid_until:
                    return certificate
        _make(path, names, now)
        return _certificate(_parsed(path, path.read_bytes()), path, path, self_signed=True)
    except OSError as error:
        raise DataError(path, f"the certificate can neither be read nor created: {error.strerror}") from error


def _make(path: Path, names: Sequence[str], now: datetime) -> None:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name(
        [x509.NameAttribute(x509.NameOID.COMMON_NAME, f"tactogram on {socket.gethostname()}"[:64])]
    )
    alternatives = [value for text in dict.fromkeys(names) if (value := _general_name(text))]
    # Not an authority: a tablet that trusts it trusts this server, and no other signed by it.
    constraints = x509.BasicConstraints(ca=False, path_length=None)
    signs_handshakes = x509.KeyUsage(True, *[False] * 8)  # and nothing else
    purpose = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
    certificate = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))  # a tablet's clock may be slow
        .not_valid_after(now + VALIDITY)
        .add_extension(x509.SubjectAlternativeName(alternatives), critical=False)
        .add_extension(constraints, critical=True)
        .add_extension(signs_handshakes, critical=True)
        .add_extension(purpose, critical=False)
        .sign(key, hashes.SHA256())
    )
    pem, plain = serialization.Encoding.PEM, serialization.NoEncryption()
    written = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, plain) + certificate.public_bytes(pem)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_secret(path, written, replace=True)


def _read(path: Path, what: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise DataError(path, f"no such file; expected the {what} in PEM format") from None
    except OSError as error:
        raise DataError(path, f"the {what} cannot be read: {error.strerror}") from None


def _parsed(path: Path, pem: bytes) -> ParsedCertificate:
    from cryptography import x509

    try:
        return x509.load_pem_x509_certificates(pem)[0]
    except ValueError:
        raise DataError(path, "not a certificate in PEM format (-----BEGIN CERTIFICATE-----)") from None


def _certificate(parsed: ParsedCertificate, file: Path, key: Path, *, self_signed: bool) -> Certificate:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes

    try:
        alternatives = parsed.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (x509.ExtensionNotFound, ValueError):
        alternatives = x509.SubjectAlternativeName([])
    hosts = [_filled_wildcard(name) for name in alternatives.get_values_for_type(x509.DNSName)]
    addresses = [str(address) for address in alternatives.get_values_for_type(x509.IPAddress)]
    return Certificate(
        file=file,
        key=key,
        names=(*hosts, *addresses),
        valid_until=parsed.not_valid_after_utc,
        sha256=parsed.fingerprint(hashes.SHA256()).hex(":").upper(),
        self_signed=self_signed,
    )


def _filled_wildcard(name: str) -> str:
    """Return this machine's name in the domain of a wildcard."""
    return name.replace("*", socket.gethostname().partition(".")[0], 1) if name.startswith("*.") else name


def _general_name(name: str) -> GeneralName | None:
    """Return a host name or address in X.509 form; None if it is not valid."""
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name) if _NAME.fullmatch(name) else None
