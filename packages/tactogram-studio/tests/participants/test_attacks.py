"""The attacks that the server is to stand, each named; over a real socket unless the attack is on a file."""

import io
import json
import os
import pickle
import re
import socket
import ssl
import struct
import threading
import zipfile
import zlib
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest

from tactogram.errors import ParameterError, TactogramError
from tactogram_studio.server.certificates import self_signed_certificate
from tactogram_studio.server.guard import RequestGuard
from tactogram_studio.server.guard_rules import COOKIE, GuardSettings
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.uploads import read_uploaded_image, read_uploaded_signal, save_upload
from tactogram_study.participants.routes import make_participant_app
from tactogram_study.participants.sessions import SessionRegistry
from tactogram_study.participants.tickets import load_keys
from tactogram_study.session.store import SessionStore

JSON = {"content-type": "application/json"}
MARKUP = "<script>alert('x')</script><img src=x onerror=alert(1)>\"'&{{7*7}}"
TOKEN = "a-token-that-nobody-guesses"
TABLET = "tablet.test"
"""What the browser of these tests calls 127.0.0.2: a name that it trusts over https only."""


@pytest.fixture(scope="module")
def under_attack(tmp_path_factory, write_study_once, person, serving):
    """Give sessions, a session, a browser's client and somebody at their first trial; the server must survive all."""
    folder = tmp_path_factory.mktemp("attacked")
    sessions = SessionRegistry(folder, device="null")
    session = sessions.begin(write_study_once(folder), folder / "session")
    with serving(sessions) as client:
        one = person(client, session.join_path)
        one.go_to("abx")
        yield sessions, session, client, one
        # Whatever was sent: the server lives, and the participant is where they were.
        assert one.page()["token"] == "trial-1.1"
        assert [row.more["token"] for row in session.store.answers().where(participant=one.code)] == [
            "consent",
            "before",
        ]
    sessions.close()


def raw(client, text, *, wait_s=5.0, then=b""):
    """Send bytes as they are, and return all that comes back until the server hangs up or is silent."""
    with socket.create_connection((client.base_url.host, client.base_url.port), timeout=wait_s) as connection:
        connection.sendall(text if isinstance(text, bytes) else text.encode())
        if then:
            connection.sendall(then)
        found = b""
        try:
            while piece := connection.recv(65536):
                found += piece
        except TimeoutError:
            pass
        return found


def connection_to(address):
    parts = urlsplit(str(address))
    return socket.create_connection((parts.hostname, parts.port), timeout=60)


def hung_up(connection):
    """Return whether the server hung up, having waited for it as long as the connection does."""
    try:
        while connection.recv(65536):
            pass
    except ConnectionError:
        pass
    return True


def status_of(answer):
    return int(answer.split()[1]) if answer.startswith(b"HTTP/1.1 ") else None


def answers_of(one):
    return {"token": "trial-1.1", "answers": {"which": "A"}}


# Other sites


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost.evil.example", "http://127.0.0.1:9"]
)
def test_foreign_origin(under_attack, origin):
    _, session, client, one = under_attack
    for path in (f"/take/{one.ticket}/answers", f"/take/{one.ticket}/stop", session.join_path):
        answered = client.post(path, json=answers_of(one), headers={"origin": origin})
        assert (answered.status_code, "error" in answered.json()) == (403, True)


def test_foreign_origin_with_a_plain_form(under_attack):
    _, _, client, one = under_attack
    # What a form of another site can send without asking: no JSON content type.
    for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""):
        answered = client.post(
            f"/take/{one.ticket}/answers", content=json.dumps(answers_of(one)), headers={"content-type": kind}
        )
        assert answered.status_code == 415


@pytest.mark.parametrize("kind", ["script", "image", "iframe", "empty"])
def test_foreign_page_embeds_what_is_here(under_attack, kind):
    _, _, client, one = under_attack
    headers = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "no-cors", "sec-fetch-dest": kind}
    assert client.get(f"/take/{one.ticket}/page", headers=headers).status_code == 403


def test_cross_origin_reading_is_allowed_to_nobody(under_attack):
    _, _, client, one = under_attack
    answered = client.get(f"/take/{one.ticket}/page", headers={"origin": "http://evil.example"})
    assert "access-control-allow-origin" not in answered.headers
    asked = {"origin": "http://evil.example", "access-control-request-method": "POST"}
    assert client.options(f"/take/{one.ticket}/answers", headers=asked).status_code == 405


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "evil.example:80", "localhost@evil.example"]
)
def test_dns_rebinding_host(under_attack, host):
    _, _, client, one = under_attack
    assert client.get(f"/take/{one.ticket}/page", headers={"host": host}).status_code in (400, 421)


def test_absolute_request_target_of_another_host(under_attack):
    _, _, client, one = under_attack
    found = raw(
        client,
        f"GET http://evil.example/take/{one.ticket}/page HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n",
    )
    assert status_of(found) in (400, 421)


# Who may ask


@pytest.mark.parametrize(
    ("proxies", "told"),
    [((), "http 127.0.0.1"), (("192.0.2.1",), "http 127.0.0.1"), (("127.0.0.0/8",), "https 203.0.113.9")],
)
def test_an_address_that_a_client_claims(served_here, monkeypatch, proxies, told):
    async def tell(scope, receive, send):
        names = [name.decode() for name, _ in scope["headers"] if b"forward" in name.lower()]
        text = " ".join([scope["scheme"], scope["client"][0], *names])
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": text.encode()})

    monkeypatch.setenv("FORWARDED_ALLOW_IPS", "*")
    claimed = {"proto": "https", "for": "203.0.113.9", "host": "evil.example", "prefix": "//evil.example"}
    headers = {f"x-forwarded-{name}": value for name, value in claimed.items()}
    with served_here(RequestGuard(tell, GuardSettings()), proxies=proxies) as address:
        assert httpx.get(address, headers={**headers, "forwarded": "for=203.0.113.9"}).text == told


def test_missing_token(under_attack, serving):
    sessions, session, _, one = under_attack
    with serving(sessions, GuardSettings(loopback=False, token=TOKEN)) as client:
        assert client.get("/openapi.json").status_code == 401
        assert client.get("/openapi.json", headers={"cookie": f"{COOKIE}=guess"}).status_code == 401
        assert client.get(f"/openapi.json?token={TOKEN}").status_code == 303
        assert client.get("/openapi.json").status_code == 200
        # Participants need their ticket only, and it opens nothing else.
        client.cookies.clear()
        assert client.get(f"/take/{one.ticket}/page").status_code == 200
        assert client.get(f"/openapi.json?token={one.ticket}").status_code == 401
        assert client.get(session.join_path).status_code == 200


def test_other_s_ticket(under_attack, person):
    sessions, session, client, one = under_attack
    other = person(client, session.join_path)
    assert other.page()["token"] == "consent"
    assert other.post("answers", **answers_of(one)).status_code == 409
    assert other.get("sound", token="trial-1.1", slot="A").status_code == 409
    elsewhere = sessions.begin("abx", session.folder.parent / "elsewhere")
    assert one.ticket != load_keys(elsewhere.folder).ticket(one.code)
    assert client.get(f"/take/{load_keys(elsewhere.folder).ticket(one.code)}/page").status_code == 404


@pytest.mark.parametrize(
    "change", [lambda t: t[:-1], lambda t: t + "A", lambda t: t.swapcase(), lambda t: "", lambda t: "%00"]
)
def test_guessed_ticket(under_attack, change):
    _, session, client, one = under_attack
    for ticket in (change(one.ticket), one.code, session.keys.join):
        assert client.get(f"/take/{ticket}/page").status_code in (400, 404)
        assert client.post(f"/take/{ticket}/answers", json=answers_of(one)).status_code in (400, 404)


def test_a_ticket_opens_no_experimenter_s_page(under_attack):
    _, _, client, one = under_attack
    for path in (
        "/",
        f"/take/{one.ticket}/progress",
        f"/take/{one.ticket}/notes",
        "/experiment/session",
        "/docs",
    ):
        assert client.get(path).status_code == 404


# Paths


@pytest.mark.parametrize(
    "path",
    [
        "../routes.py",
        "..%2froutes.py",
        "%2e%2e/routes.py",
        "..%5croutes.py",
        "%2fetc%2fpasswd",
        "....//routes.py",
        "take.js%00.css",
        "..%252froutes.py",
        "take.py",
        ".hidden.js",
    ],
)
def test_path_traversal_in_static_files(under_attack, path):
    _, _, client, _ = under_attack
    found = raw(
        client, f"GET /participants/static/{path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
    )
    assert status_of(found) in (400, 404)
    assert b"import" not in found


@pytest.mark.parametrize(
    "name", ["../../outside.wav", "/etc/passwd", "files/../../outside.wav", "link.wav", "folder/x.wav"]
)
def test_path_traversal_in_a_study_s_stimuli(tmp_path, write_study, name):
    workspace = tmp_path / "workspace"
    (workspace / "files").mkdir(parents=True)
    (tmp_path / "outside.wav").write_bytes(b"RIFF")
    (workspace / "link.wav").symlink_to(tmp_path / "outside.wav")
    (workspace / "folder").symlink_to(tmp_path)
    for key in ("file", "image", "run", "image_run"):
        study = write_study(
            workspace, stimuli=[{"name": n, "item": "a", "condition": n, key: name} for n in "ab"]
        )
        sessions = SessionRegistry(workspace)
        with pytest.raises(TactogramError, match="is outside the study's folder and the workspace"):
            sessions.begin(study, workspace / "session")
        assert not (workspace / "session").exists()


def test_path_traversal_in_a_study_s_display(tmp_path, write_study):
    workspace = tmp_path / "workspace"
    workspace.mkdir()
    (tmp_path / "secret.toml").write_text("password = 1")
    (workspace / "own.toml").write_text('family = "linear"\nresponse = { file = "../secret.csv" }')
    for display in ("../secret.toml", str(tmp_path / "secret.toml"), "own.toml"):
        study = write_study(workspace, display=display)
        with pytest.raises(TactogramError, match="is outside") as caught:
            SessionRegistry(workspace).begin(study, workspace / "session")
        assert "password" not in str(caught.value)


@pytest.mark.parametrize("folder", ["..", "../x", "/tmp/x", "a/../../x"])
def test_path_traversal_in_a_session_s_folder(tmp_path, write_study, folder):
    workspace = tmp_path / "workspace"
    workspace.mkdir()
    sessions = SessionRegistry(workspace)
    for do in (sessions.open, lambda path: sessions.begin("abx", path)):
        with pytest.raises(ParameterError, match="lies outside of the workspace"):
            do(Path(folder))
    outside = write_study(tmp_path)
    for study in (outside, "../small.toml"):
        with pytest.raises(ParameterError, match="lies outside of the workspace"):
            sessions.begin(study, workspace / "session")


def test_symlink_out_of_the_workspace(tmp_path):
    (tmp_path / "workspace").mkdir()
    (tmp_path / "outside").mkdir()
    workspace = Workspace.at(tmp_path / "workspace")
    (workspace.folder / "link").symlink_to(tmp_path / "outside")
    for path in ("link", "link/a.wav", "../outside", "/etc/passwd", "a\0b"):
        with pytest.raises(ParameterError):
            workspace.inside(path)
    with pytest.raises(ParameterError, match="outside"):
        SessionRegistry(workspace.folder).open(workspace.folder / "link")
    # Names of uploads hold no path; a link that lies there is not written through.
    (workspace.folder / "a.csv").symlink_to(tmp_path / "outside" / "a.csv")
    save_upload(workspace.folder, "../../outside/a.csv", b"1\n", kind="table")
    assert list((tmp_path / "outside").iterdir()) == []


# Bodies


def test_oversized_body(under_attack):
    _, _, client, one = under_attack
    answered = client.post(f"/take/{one.ticket}/answers", content=b"x" * 70_000, headers=JSON)
    assert (answered.status_code, answered.json()["error"]) == (
        413,
        "At most 64 KiB can be sent here; send less.",
    )
    head = (
        f"POST /take/{one.ticket}/answers HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    )
    for length in ("99999999999999999999999", "-1", "1e9", "0x10", "12abc"):
        assert status_of(raw(client, f"{head}Content-Length: {length}\r\n\r\n")) in (400, 413)


def test_chunked_oversize(under_attack):
    _, _, client, one = under_attack

    def pieces():
        for _ in range(100):
            yield b"[" * 10_000

    answered = client.post(f"/take/{one.ticket}/answers", content=pieces(), headers=JSON)
    assert answered.status_code == 413


def test_chunk_of_a_false_size_and_two_lengths(under_attack):
    _, _, client, one = under_attack
    head = (
        f"POST /take/{one.ticket}/answers HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    )
    chunked = f"{head}Transfer-Encoding: chunked\r\n"
    for rest in (
        "\r\nffffffffffffffffff\r\n{}\r\n0\r\n\r\n",
        "\r\nzz\r\n{}\r\n0\r\n\r\n",
        "Content-Length: 3\r\n\r\n2\r\n{}\r\n0\r\n\r\n",
    ):
        # A size that never comes is waited for, and given up.
        assert status_of(raw(client, chunked + rest)) in (400, 408)


MALFORMED = [
    b"",
    b"{",
    b"nonsense",
    b"[]",
    b"null",
    b'"text"',
    b"\xff\xfe\x00",
    b'{"token": "trial-1.1"',
    b'{"token": 1, "answers": {}}',
    b'{"token": "trial-1.1", "answers": []}',
    b'{"token": "trial-1.1", "answers": {"which": ["A"]}}',
    b'{"token": "trial-1.1", "answers": {"which": null}}',
    b'{"token": "trial-1.1", "answers": {"which": "\\ud800"}}',
    b'{"token": "\\ud800", "answers": {}}',
    b'{"token": "trial-1.1", "answers": {"\\ud800": "A"}}',
    b'{"token": "trial-1.1", "answers": {}, "more": 1}',
    b'{"token": "trial-1.1", "answers": {"__proto__": "A"}}',
    b'{"token": "trial-1.1\\u0000", "answers": {"which": "A"}}',
]


@pytest.mark.parametrize("body", MALFORMED)
def test_malformed_json(under_attack, body):
    _, session, client, one = under_attack
    for path in (f"/take/{one.ticket}/answers", f"/take/{one.ticket}/play", session.join_path):
        answered = client.post(path, content=body, headers=JSON)
        assert 400 <= answered.status_code < 500
        assert len(answered.json()["error"]) > 10
        assert "\n" not in answered.json()["error"]


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 60_000,
        b'{"a":' * 12_000,
        b'{"token": "trial-1.1", "answers": {"which": "C"}, "device": '
        + b'{"a":' * 5000
        + b"1"
        + b"}" * 5000
        + b"}",
        b'{"token": "trial-1.1", "answers": {"which": "C"}, "rt_ms": {"": 1e999}}',
        b'{"token": "trial-1.1", "answers": {"which": "C"}, "rt_ms": {"": NaN}}',
        b'{"token": "trial-1.1", "answers": {"which": "C"}, "rt_ms": {"": ' + b"9" * 5000 + b"}}",
        b'{"token": "trial-1.1", "answers": {"which": "C"}, "device": {"a": ' + b"9" * 4000 + b"}}",
        b'{"token": "trial-1.1", "answers": {"which": "' + b"9" * 4100 + b'"}}',
    ],
)
def test_huge_numbers_and_deep_nesting(under_attack, body):
    _, _, client, one = under_attack
    answered = client.post(f"/take/{one.ticket}/answers", content=body, headers=JSON)
    assert 400 <= answered.status_code < 500
    assert len(answered.json()["error"]) < 400


def test_numbers_that_are_none_lose_no_answer(tmp_path, opened, person):
    _, session, client = opened(tmp_path)
    one = person(client, session.join_path)
    body = (
        b'{"token": "consent", "answers": {"consent": "agreed"}, "rt_ms": {"": NaN, "consent": -1e400, "x": 1e300}, '
        b'"device": {"a": Infinity, "b": '
        + b"9" * 400
        + b', "c": "\\ud800", "d": {"e": [[1]]}, "px_per_mm": 6}}'
    )
    answered = client.post(f"/take/{one.ticket}/answers", content=body, headers=JSON)
    assert answered.json()["stored"]
    [row] = session.store.answers()
    assert np.isnan(row.rt_ms)
    assert {name: text for name, text in row.more.items() if name.startswith("device_")}[
        "device_px_per_mm"
    ] == "6"


def test_header_injection(under_attack):
    _, session, client, one = under_attack
    for path in (
        f"/take/{one.ticket}/sound?token=trial-1.1%0d%0aSet-Cookie:%20a=b&slot=A",
        "/join/a%0d%0aX-Evil:%201",
    ):
        answered = client.get(path)
        assert 400 <= answered.status_code < 500
        assert not {"set-cookie", "x-evil"} & set(answered.headers)
    found = raw(client, f"GET {session.join_path} HTTP/1.1\r\nHost: 127.0.0.1\r\nX-A: b\rX-Evil: 1\n\r\n\r\n")
    assert status_of(found) in (400, None)


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH"])
def test_http_method_override(under_attack, method):
    _, _, client, one = under_attack
    path = f"/take/{one.ticket}/answers"
    for name in ("x-http-method-override", "x-http-method", "x-method-override"):
        assert client.get(f"{path}?_method=POST", headers={name: "POST"}).status_code == 405
        assert client.get(f"/take/{one.ticket}/page", headers={name: method}).status_code == 200
    assert client.request(method, path, json=answers_of(one)).status_code == 405


def test_request_smuggling_by_a_second_request(under_attack):
    _, _, client, one = under_attack
    inner = f"GET /take/{one.ticket}/page HTTP/1.1\r\nHost: evil.example\r\n\r\n"
    found = raw(
        client,
        "POST /join/x HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 2\r\n"
        f"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n{inner}",
        wait_s=2,
    )
    assert status_of(found) == 400
    assert found.count(b"HTTP/1.1 200") == 0


@pytest.mark.parametrize(
    "text",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET\r\n\r\n",
        b"\0" * 100,
        b"GET / HTTP/9.9\r\n\r\n",
        b"A" * 100_000,
    ],
)
def test_what_is_no_http(under_attack, text):
    _, _, client, _ = under_attack
    assert status_of(raw(client, text, wait_s=1)) in (400, 413, 414, 431, None)


# Slow senders


def test_half_requests_do_not_block_others(under_attack):
    _, _, client, one = under_attack
    head = (
        f"POST /take/{one.ticket}/answers HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    )
    halves = ["GET /take/x HTTP/1.1\r\nHost: 127.", f"{head}Content-Length: 500\r\n\r\n" + '{"token"']
    connections = []
    for n in range(60):
        connection = socket.create_connection((client.base_url.host, client.base_url.port), timeout=60)
        connection.sendall(halves[n % 2].encode())
        connections.append(connection)
    for _ in range(5):
        assert one.page()["token"] == "trial-1.1"
    # Those who began a body and stall are sent away (after 1 s here).
    assert status_of(connections[1].recv(4096)) == 408
    for connection in connections:
        connection.close()


def test_headers_without_end(under_attack):
    _, _, client, _ = under_attack

    def send(connection):
        connection.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        for _ in range(20_000):
            connection.sendall(b"X-A: " + b"y" * 8000 + b"\r\n")

    with connection_to(client.base_url) as connection, pytest.raises(OSError, match="reset|Broken pipe"):
        send(connection)


def test_what_is_no_tls_and_handshakes_that_never_end(under_attack, person, served_here, tmp_path):
    sessions, session, _, _ = under_attack
    app = RequestGuard(make_participant_app(sessions), GuardSettings())
    kept = self_signed_certificate(tmp_path / "https.pem", ["127.0.0.1"])
    trusting = ssl.create_default_context(cafile=kept.file)
    with served_here(app, kept.context()) as address, ExitStack() as held:
        _, plain, half, *_ = (held.enter_context(connection_to(address)) for _ in range(40))
        plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        half.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")
        with httpx.Client(base_url=address, timeout=60, verify=trusting) as client:
            assert person(client, session.join_path).page()["token"] == "consent"
        assert hung_up(plain)


def test_who_sleeps_or_stops_on_the_way_is_not_waited_for_at_the_end(served_here, tmp_path, capsys):
    told, begun = [], threading.Event()

    async def receives(scope, receive, send):
        while scope["type"] == "http":
            told.append((await receive())["type"])
            begun.set()
            if told[-1] == "http.disconnect":
                break

    kept = self_signed_certificate(tmp_path / "https.pem", ["127.0.0.1"])
    trusting = ssl.create_default_context(cafile=kept.file)
    with ExitStack() as held:
        with served_here(receives, context=kept.context()) as address:
            _, half = (
                held.enter_context(trusting.wrap_socket(connection_to(address), server_hostname="127.0.0.1"))
                for _ in range(2)
            )
            half.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 50\r\n\r\n{")
            assert begun.wait(60)
        assert told == ["http.request", "http.disconnect"]
    assert capsys.readouterr().err == ""


def test_hanging_up_in_the_middle(under_attack):
    _, _, client, one = under_attack
    for path in ("answers", "play"):
        connection = socket.create_connection((client.base_url.host, client.base_url.port))
        connection.sendall(
            f"POST /take/{one.ticket}/{path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 50\r\n\r\n{{".encode()
        )
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        connection.close()
    assert one.page()["token"] == "trial-1.1"


def test_websocket_from_foreign_origin(under_attack):
    _, _, client, _ = under_attack
    for origin in ("http://evil.example", "null"):
        found = raw(
            client,
            "GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            f"Upgrade: websocket\r\nConnection: Upgrade\r\nOrigin: {origin}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
            wait_s=2,
        )
        assert status_of(found) == 403


# Texts of participants


def test_markup_in_answers_is_kept_as_text_and_sent_as_json(tmp_path, opened, person):
    _, session, client = opened(
        tmp_path, before=[{"id": "hand", "text": MARKUP, "kind": "text"}], title=MARKUP
    )
    one = person(client, session.join_path)
    page = one.go_to("questions")
    shown = one.get("page")
    assert (shown.headers["content-type"], shown.headers["x-content-type-options"]) == (
        "application/json",
        "nosniff",
    )
    assert (shown.json()["title"], page["questions"][0]["text"]) == (MARKUP, MARKUP)
    assert one.post("answers", token="before", answers={"hand": MARKUP}).json()["stored"]
    [row] = session.store.answers().where(question="hand")
    assert row.answer == MARKUP
    # The pages are the same for all, whatever anybody wrote, and run no inline script.
    for path in (session.join_path, f"/take/{one.ticket}"):
        answered = client.get(path)
        assert "alert(" not in answered.text
        assert "script-src 'self';" in answered.headers["content-security-policy"]
    code = client.post(session.join_path, json={"code": MARKUP[:40], "language": "en"})
    assert (code.status_code, code.headers["content-type"]) == (404, "application/json")


@pytest.mark.parametrize(
    "text", ["=1+1", "@SUM(A1)", "'; DROP TABLE answers; --", "a\0b", "\x1b[2J", "\u202egnp", "🙂" * 900]
)
def test_texts_that_other_programs_would_run_are_stored_as_they_are(tmp_path, opened, person, text):
    _, session, client = opened(tmp_path, before=[{"id": "hand", "text": "Say.", "kind": "text"}])
    one = person(client, session.join_path)
    one.go_to("questions")
    assert one.post("answers", token="before", answers={"hand": text}).json()["stored"]
    [row] = session.store.answers().where(question="hand")
    assert row.answer == text.strip()


# Files


def png_of(rows, columns):
    head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")
    )


def test_decompression_bomb():
    picture = png_of(50_000, 50_000)
    with pytest.raises(TactogramError, match="at most 67108864 pixels"):
        read_uploaded_image("a.png", picture)
    file = io.BytesIO()
    with (
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("x.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (2**26,)}
        )
        for _ in range(260):
            member.write(bytes(2**20))
    with pytest.raises(TactogramError, match="must unpack to at most 256 MiB"):
        read_uploaded_signal("a.npz", file.getvalue())


def test_pickle_in_npz(tmp_path):
    class Evil:
        def __reduce__(self):
            return (os.mkdir, (str(tmp_path / "ran"),))

    file = io.BytesIO()
    np.savez(file, samples=np.array([Evil()], dtype=object))
    with pytest.raises(TactogramError, match="pickled objects"):
        read_uploaded_signal("a.npz", file.getvalue())
    with pytest.raises(TactogramError, match="a.npz"):
        read_uploaded_signal("a.npz", pickle.dumps(Evil()))
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    "data",
    [b"MZ\x90\0" * 30, b"\x7fELF\x02\x01\x01" * 30, b"#!/bin/sh\nrm -rf /\n", b"<html><script>1</script>"],
)
@pytest.mark.parametrize("name", ["a.wav", "a.png", "a.npz", "a.toml", "a.xlsx"])
def test_renamed_executable(tmp_path, name, data):
    kind = {"a.png": "image", "a.toml": "study", "a.xlsx": "table"}.get(name, "signal")
    with pytest.raises(TactogramError, match=name) as caught:
        save_upload(tmp_path / "kept", name, data, kind=kind)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "kept").exists()


# Many at once


def test_many_who_guess_do_not_keep_people_out(under_attack, person):
    _, session, client, one = under_attack
    threads = [threading.Thread(target=lambda n=n: client.get(f"/take/{'x' * n}/page")) for n in range(1, 30)]
    for thread in threads:
        thread.start()
    assert one.page()["token"] == "trial-1.1"
    for thread in threads:
        thread.join()
    assert person(client, session.join_path).page()["token"] == "consent"


# The whole server, in a browser


@pytest.fixture(scope="module")
def laboratory_s(tmp_path_factory):
    """Give a certificate of a laboratory, for a name that the browser of these tests knows."""
    return self_signed_certificate(tmp_path_factory.mktemp("certified") / "lab.pem", [TABLET, "127.0.0.2"])


@pytest.fixture(scope="module")
def study_server(tmp_path_factory, write_study_once, served, laboratory_s):
    """Give folder and addresses of `study run`, all of whose texts are markup, reached as if from another machine.

    It listens on every address: on one of this machine's own alone it would need no token.
    """
    folder = tmp_path_factory.mktemp("served")
    choice = {
        "id": "hand",
        "kind": "choice",
        "text": MARKUP,
        "options": [{"value": v, "text": MARKUP} for v in "rl"],
    }
    line = {
        "id": "line",
        "kind": "vas",
        "low": 0,
        "high": 9,
        "text": MARKUP,
        "low_text": MARKUP,
        "high_text": MARKUP,
    }
    free = {"id": "free", "kind": "text", "text": MARKUP}
    study = write_study_once(folder, title=MARKUP, consent=MARKUP, before=[choice, line, free])
    verb = (
        *("study", "run", str(study), "--out", "session", "--host", "0.0.0.0", "--port", "0"),
        *("--certificate", str(laboratory_s.file), "--no-open", "--json"),
    )
    with served(*verb, folder=folder, prefix="{") as (_, rest):
        yield folder, json.loads("{" + rest)


@pytest.fixture
def asking(study_server, laboratory_s):
    """Give a client to the whole server that checks its certificate, without a cookie."""
    base = study_server[1]["join"].partition("/join/")[0].replace(TABLET, "127.0.0.2")
    trusting = ssl.create_default_context(cafile=laboratory_s.file)
    with httpx.Client(base_url=base, timeout=60, verify=trusting) as client:
        yield client


def test_missing_token_at_the_whole_server(study_server, asking):
    _, facts = study_server
    path, _, token = facts["experimenter"].partition(TABLET)[2].partition("/")[2].partition("?token=")
    for place in (
        f"/{path}",
        "/",
        "/_nicegui_ws/socket.io/?EIO=4&transport=polling",
        "/openapi.json",
        f"/{path}?token=x",
    ):
        assert asking.get(place).status_code == 401
    assert asking.get(f"/join/{facts['join'].rpartition('/')[2]}").status_code == 200
    told = asking.get(f"/{path}?token={token}")
    assert (told.status_code, told.headers["location"]) == (303, f"/{path}")
    assert {"HttpOnly", "SameSite=strict", "Secure"} <= set(told.headers["set-cookie"].split("; "))
    shown = asking.get(f"/{path}")
    assert shown.status_code == 200
    # NiceGUI's own, too, is for this server and encrypted connections alone.
    assert re.match("__Host-tactogram_session=.*; secure", shown.headers["set-cookie"])


def test_websocket_from_foreign_origin_at_the_whole_server(study_server, asking, laboratory_s):
    token = study_server[1]["experimenter"].partition("?token=")[2]
    asked = (
        "GET /_nicegui_ws/socket.io/?EIO=4&transport=websocket HTTP/1.1\r\nHost: 127.0.0.2\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    )
    knows = f"Cookie: __Host-{COOKIE}={token}\r\n"
    own, other, plain = (
        f"Origin: {site}\r\n" for site in ("https://127.0.0.2", "https://evil.example", "http://127.0.0.2")
    )
    trusting = ssl.create_default_context(cafile=laboratory_s.file)
    for more, status in ((knows + own, 101), (knows + other, 403), (knows + plain, 403), (own, 403)):
        with trusting.wrap_socket(connection_to(asking.base_url), server_hostname="127.0.0.2") as connection:
            connection.sendall(f"{asked}{more}\r\n".encode())
            assert status_of(connection.recv(4096)) == status


WORKLET = """async () => {
  const context = new OfflineAudioContext(1, 128, 48000);
  await context.audioWorklet.addModule('/static/touch_worklet.js');
  new AudioWorkletNode(context, 'tactogram-touch', {numberOfInputs: 0}).connect(context.destination);
  return [isSecureContext, (await context.startRendering()).length];
}"""


def test_a_tablet_is_given_the_sound_thread_over_https(study_server, browser):
    facts = study_server[1]
    assert facts["join"].startswith(
        f"https://{TABLET}:"
    )  # the certificate's name, which is none of this machine's own
    assert [urlsplit(one).hostname for one in facts["addresses"]] == ["127.0.0.2"]
    context = browser.new_context(ignore_https_errors=True)
    page = context.new_page()
    page.goto(facts["join"])
    assert page.evaluate(WORKLET) == [True, 128]
    page.goto(facts["experimenter"])
    page.get_by_role("img", name="QR code: Address to take part").wait_for()
    link = page.get_by_role("link", name="Address to take part")
    assert link.get_attribute("href") == facts["join"]
    context.close()


def test_xss_in_titles_questions_notes_and_answers(study_server, asking, browser, person):
    """Everything that somebody wrote is markup; every page shows it as text, and none of it runs."""
    folder, facts = study_server
    with SessionStore(folder / "session") as store:
        store.note(MARKUP)
    base, _, key = facts["join"].partition("/join/")
    context = browser.new_context(ignore_https_errors=True)
    page = context.new_page()
    dialogs = []
    page.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    one = person(asking, f"/join/{key}")
    page.goto(facts["join"])
    expect_text(page)
    page.goto(f"{base}/take/{one.ticket}")
    expect_text(page)
    one.answer()
    page.reload()
    expect_text(page)
    one.post("answers", token="before", answers={"hand": "r", "line": "3", "free": MARKUP})
    page.goto(facts["experimenter"])
    expect_text(page)
    assert "token" not in page.url
    assert dialogs == []
    assert page.locator("img[src=x]").count() == 0
    context.close()


def expect_text(page):
    """Wait until the markup stands on a page as text."""
    page.get_by_text("<script>alert('x')</script>").first.wait_for()
