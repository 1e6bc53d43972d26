import hashlib
import ssl
import stat
from datetime import UTC, datetime, timedelta

import pytest

from tactogram.errors import DataError
from tactogram_studio.server.certificates import RENEWAL, VALIDITY, load_certificate, self_signed_certificate

x509 = pytest.importorskip("cryptography.x509")
hashes = pytest.importorskip("cryptography.hazmat.primitives.hashes")
ed25519 = pytest.importorskip("cryptography.hazmat.primitives.asymmetric.ed25519")
serialization = pytest.importorskip("cryptography.hazmat.primitives.serialization")

NOW = datetime(2026, 3, 1, tzinfo=UTC)
NAMES = ("192.0.2.7", "lab-pc", "localhost", "::1")
BEGIN = b"-----BEGIN CERTIFICATE-----\n"


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Give a certificate that holds now."""
    return self_signed_certificate(tmp_path_factory.mktemp("kept") / "https.pem", NAMES)


@pytest.fixture
def pair(kept, tmp_path):
    """Give the same as two files."""
    key, begin, certificate = kept.file.read_bytes().partition(BEGIN)
    (tmp_path / "key.pem").write_bytes(key)
    (tmp_path / "certificate.pem").write_bytes(begin + certificate)
    return tmp_path / "certificate.pem", tmp_path / "key.pem"


def hands_shaken(server, client, name):
    """Return the client's side of TLS after a handshake in memory."""
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    asking = client.wrap_bio(back, there, server_hostname=name)
    sides = [asking, server.wrap_bio(there, back, server_side=True)]
    for side in sides * 3:
        try:
            side.do_handshake()
        except ssl.SSLWantReadError:
            continue
    return asking


def test_a_certificate_is_kept_for_its_owner_and_used_again(tmp_path):
    path = tmp_path / "state" / "https.pem"
    first = self_signed_certificate(path, (*NAMES, "no name of a host!"), now=NOW)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert list(path.parent.iterdir()) == [path]
    assert (set(first.names), first.valid_until, first.self_signed) == (set(NAMES), NOW + VALIDITY, True)
    path.chmod(0o644)
    for names in (NAMES, NAMES[1:]):
        assert self_signed_certificate(path, names, now=NOW + VALIDITY - RENEWAL) == first
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize(
    ("names", "later", "damaged"),
    [
        (("192.0.2.8", "lab-pc"), timedelta(0), lambda pem: pem),
        (NAMES, VALIDITY - RENEWAL + timedelta(seconds=1), lambda pem: pem),
        (NAMES, timedelta(0), lambda pem: b""),
        (NAMES, timedelta(0), lambda pem: pem[pem.index(BEGIN) :]),
    ],
)
def test_a_new_one_is_made_where_addresses_changed_it_runs_out_or_is_damaged(tmp_path, names, later, damaged):
    path = tmp_path / "https.pem"
    first = self_signed_certificate(path, NAMES, now=NOW)
    path.write_bytes(damaged(path.read_bytes()))
    second = self_signed_certificate(path, names, now=NOW + later)
    assert second.sha256 != first.sha256
    assert set(second.names) == set(names)
    second.context()


def test_where_none_can_be_kept_it_is_told(tmp_path):
    (tmp_path / "state").write_text("no folder")
    with pytest.raises(DataError, match="can neither be read nor created"):
        self_signed_certificate(tmp_path / "state" / "https.pem", NAMES)


def test_who_trusts_it_is_answered_under_its_names_only_and_sees_its_fingerprint(kept):
    trusting = ssl.create_default_context(cafile=kept.file)
    for name in NAMES:
        shown = hands_shaken(kept.context(), trusting, name).getpeercert(True)
        assert bytes.fromhex(kept.sha256.replace(":", "")) == hashlib.sha256(shown).digest()
    with pytest.raises(ssl.SSLCertVerificationError, match="evil.example"):
        hands_shaken(kept.context(), trusting, "evil.example")


def test_it_is_a_server_s_and_no_authority_s_and_ends_within_398_days(kept, tmp_path):
    made = x509.load_pem_x509_certificate(kept.file.read_bytes())
    value = {found.oid._name: found.value for found in made.extensions}
    assert list(value["extendedKeyUsage"]) == [x509.oid.ExtendedKeyUsageOID.SERVER_AUTH]
    assert (value["keyUsage"].digital_signature, value["keyUsage"].key_cert_sign) == (True, False)
    assert not value["basicConstraints"].ca
    assert made.not_valid_after_utc - made.not_valid_before_utc < timedelta(days=398)
    other = self_signed_certificate(tmp_path / "other.pem", NAMES).file
    assert x509.load_pem_x509_certificate(other.read_bytes()).serial_number != made.serial_number


def test_nothing_older_than_tls_1_2_is_spoken(kept):
    assert kept.context().minimum_version == ssl.TLSVersion.TLSv1_2
    client = ssl.create_default_context(cafile=kept.file)
    client.maximum_version = ssl.TLSVersion.TLSv1_2
    assert hands_shaken(kept.context(), client, "lab-pc").version() == "TLSv1.2"


def test_a_laboratory_s_own_is_taken_from_two_files_or_one(kept, pair):
    for files in (pair, (kept.file, kept.file)):
        found = load_certificate(*files)
        assert (found.names, found.sha256, found.self_signed) == (kept.names, kept.sha256, False)


def test_one_for_all_names_of_a_domain_holds_for_this_machine_s(pair, monkeypatch):
    monkeypatch.setattr("socket.gethostname", lambda: "lab-pc.local")
    key = serialization.load_pem_private_key(pair[1].read_bytes(), None)
    name, now = x509.Name([]), datetime.now(UTC)
    held = x509.SubjectAlternativeName([x509.DNSName("*.lab.example"), x509.DNSName("touch.example")])
    signed = (
        x509.CertificateBuilder(name, name, key.public_key(), 1, now - timedelta(1), now + timedelta(1))
        .add_extension(held, critical=False)
        .sign(key, hashes.SHA256())
    )
    pair[0].write_bytes(signed.public_bytes(serialization.Encoding.PEM))
    assert load_certificate(*pair).names == ("lab-pc.lab.example", "touch.example")


def of_another_kind(pem):
    pem, form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    return ed25519.Ed25519PrivateKey.generate().private_bytes(pem, form, serialization.NoEncryption())


def locked(pem):
    key = serialization.load_pem_private_key(pem, None)
    pem, form = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    return key.private_bytes(pem, form, serialization.BestAvailableEncryption(b"word"))


@pytest.mark.parametrize(
    ("which", "written", "told"),
    [
        (0, lambda pem: None, "certificate.pem: no such file; expected the certificate in PEM format"),
        (1, lambda pem: None, "key.pem: no such file; expected the key in PEM format"),
        (0, lambda pem: b"\x30\x82\x01", "certificate.pem: not a certificate in PEM format"),
        (1, lambda pem: b"nonsense", "key.pem: not a private key in PEM format"),
        (1, of_another_kind, "key.pem: is not the key of"),
        (1, locked, "key.pem: is locked by a password; use a key without one"),
    ],
)
def test_files_that_cannot_be_used_are_told_in_a_line(pair, which, written, told):
    text = written(pair[which].read_bytes())
    pair[which].unlink()
    if text is not None:
        pair[which].write_bytes(text)
    with pytest.raises(DataError) as caught:
        load_certificate(*pair)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_do_not_belong_together_and_one_that_ran_out_are_told(pair, tmp_path):
    other = self_signed_certificate(tmp_path / "other.pem", NAMES).file
    with pytest.raises(DataError, match=r"other.pem: is not the key of .*certificate.pem; use"):
        load_certificate(pair[0], other)
    with pytest.raises(DataError, match="cannot be read: Is a directory"):
        load_certificate(tmp_path, pair[1])
    for now in (datetime(2020, 1, 1, tzinfo=UTC), datetime(2120, 1, 1, tzinfo=UTC)):
        with pytest.raises(DataError, match="not now; renew it"):
            load_certificate(*pair, now=now)
