import asyncio
import json
import re

import pytest
from matplotlib.figure import Figure

from tactogram.evaluation.report import ReportFigure, ReportSection, ReportSound, write_report
from tactogram.signal import Signal
from tactogram_studio.server.guard import PARTICIPANT_POLICY, REPORT_POLICY, STUDIO_POLICY, RequestGuard
from tactogram_studio.server.guard_rules import (
    COOKIE,
    KIB,
    MIB,
    GuardSettings,
    token_in_query,
)
from tactogram_study.wording import complete_texts

TOKEN = "a-token-that-nobody-guesses"


LOCAL = GuardSettings()


CHUNKED = [("transfer-encoding", "chunked")]


FAR = GuardSettings(loopback=False, token=TOKEN, hosts=("lab-pc",))


class Instant(asyncio.SelectorEventLoop):
    """A loop whose clock goes on to what is waited for, so that waiting takes no time."""

    now = 0.0

    def time(self):
        return self.now

    def _run_once(self):
        if not self._ready and self._scheduled:
            self.now = max(self.now, self._scheduled[0].when())
        super()._run_once()


async def echo(scope, receive, send):
    """Read the whole body and say how long it was."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        while (message := await receive())["type"] == "websocket.receive":
            await send({"type": "websocket.send", "text": str(len(message["text"]))})
        return
    length, more = 0, True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ConnectionError
        length += len(message.get("body", b""))
        more = message.get("more_body", False)
    if scope["path"] == "/broken":
        raise ZeroDivisionError("a secret of the inside")
    await send({"type": "http.response.start", "status": 200, "headers": [(b"x-own", b"1")]})
    await send({"type": "http.response.body", "body": str(length).encode()})


def ask(
    path="/",
    method="GET",
    *,
    headers=(),
    query="",
    pieces=(b"",),
    settings=LOCAL,
    app=echo,
    host="127.0.0.1",
    scheme="http",
    every_s=0.0,
):
    """Return status, headers and body of an answer, asked without a server."""
    given = [("host", host)] if host is not None else []
    scope = {
        "type": "http",
        "method": method,
        "scheme": scheme,
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in [*given, *headers]],
    }
    waiting = [{"type": "http.request", "body": piece, "more_body": True} for piece in pieces]
    if pieces:
        waiting[-1]["more_body"] = False
    sent = []

    async def receive():
        await asyncio.sleep(every_s if waiting else 3600)
        return waiting.pop(0)

    async def send(message):
        sent.append(message)

    with asyncio.Runner(loop_factory=Instant) as runner:
        runner.run(RequestGuard(app, settings)(scope, receive, send))
    answered = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], answered, b"".join(message.get("body", b"") for message in sent[1:])


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "localhost:8123", "[::1]:8123", "LOCALHOST", "127.0.0.9", "localhost."]
)
def test_this_machine_is_answered_under_its_own_names(host):
    assert ask(host=host)[0] == 200


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("evil.example", 421),
        ("127.0.0.1.evil.example", 421),
        ("192.168.0.7", 421),
        ("", 400),
        ("a b", 400),
        (None, 400),
    ],
)
def test_other_names_are_refused_on_loopback(host, status):
    assert ask(host=host)[0] == status


@pytest.mark.parametrize(
    ("host", "status"), [("192.168.0.7:80", 401), ("lab-pc", 401), ("LAB-PC.", 401), ("x.lab-pc", 421)]
)
def test_beyond_loopback_addresses_and_given_names_are_known(host, status):
    assert ask(host=host, settings=FAR)[0] == status


def test_two_host_headers_are_refused():
    assert ask(headers=[("host", "localhost")])[0] == 400


@pytest.mark.parametrize(
    ("path", "query", "status"),
    [
        ("/experiment/a\0b", "", 400),
        ("/make/photo/a\nb", "", 400),
        ("/make", "of=a%00b", 400),
        ("/make", "of=a%0d%0aSet-Cookie:%20x=1", 400),
        ("/take/\x7f", "", 400),
        ("/experiment/" + "x" * 256, "", 400),
        ("/experiment/" + "🙂" * 64, "", 400),
        ("/experiment/" + "x" * 255, "of=" + "x" * 5000, 200),
        ("/experiment/\u202egnp.🙂", "of=%E2%80%AE%F0%9F%99%82%ff%zz..%2f", 200),
    ],
)
def test_addresses_that_name_nothing_are_refused_in_one_line(path, query, status):
    answered = ask(path, query=query)
    assert answered[0] == status
    if status == 400:
        assert re.fullmatch(
            r"(A name in an|An) address must [\w ,]+(; remove them)?\.", json.loads(answered[2])["error"]
        )


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"])
def test_methods_that_nothing_uses_are_refused(method):
    assert ask(method=method)[0] == 405


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ([], 200),
        ([("origin", "http://127.0.0.1:8123")], 200),
        ([("origin", "http://127.0.0.1:8124")], 403),
        ([("origin", "http://localhost:8123")], 403),
        ([("origin", "https://evil.example")], 403),
        ([("origin", "null")], 403),
        ([("origin", "http://127.0.0.1:8123"), ("origin", "http://evil.example")], 403),
        ([("origin", "http://127.0.0.1:99999")], 403),
        ([("sec-fetch-site", "cross-site")], 403),
        ([("sec-fetch-site", "same-site")], 403),
        ([("sec-fetch-site", "same-origin")], 200),
        ([("sec-fetch-site", "none")], 200),
        (
            [
                ("sec-fetch-site", "cross-site"),
                ("sec-fetch-mode", "navigate"),
                ("sec-fetch-dest", "document"),
            ],
            403,
        ),
    ],
)
def test_only_own_pages_change_state(headers, status):
    assert ask(method="POST", headers=headers, host="127.0.0.1:8123")[0] == status


def test_a_link_elsewhere_opens_a_page_and_embeds_none():
    linked = [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")]
    for kind, status in (("document", 200), ("iframe", 403), ("image", 403)):
        assert ask(headers=[*linked, ("sec-fetch-dest", kind)])[0] == status


def test_a_token_in_the_address_becomes_a_cookie_and_leaves_the_address():
    status, headers, _ = ask("/make", query=f"a=1&token={TOKEN}", settings=FAR)
    assert (status, headers["location"]) == (303, "/make?a=1")
    assert headers["set-cookie"] == f"{COOKIE}={TOKEN}; HttpOnly; Path=/; SameSite=strict"
    assert ask("/make", headers=[("cookie", f"x=1; {COOKIE}={TOKEN}")], settings=FAR)[0] == 200


def test_over_https_the_cookie_is_never_sent_without_and_one_that_came_without_counts_nothing():
    headers = ask("/make", query=f"token={TOKEN}", settings=FAR, scheme="https")[1]
    assert headers["set-cookie"] == f"__Host-{COOKIE}={TOKEN}; HttpOnly; Path=/; SameSite=strict; Secure"
    for name, status in ((f"__Host-{COOKIE}", 200), (COOKIE, 401)):
        given = [("cookie", f"{name}={TOKEN}")]
        assert ask("/make", headers=given, settings=FAR, scheme="https")[0] == status


def test_over_https_a_page_of_this_host_that_came_without_is_another_site():
    for origin, host, status in (
        ("https://lab-pc", "lab-pc", 200),
        ("https://lab-pc:8123", "lab-pc:8123", 200),
        ("http://lab-pc", "lab-pc", 403),
        ("http://lab-pc:8123", "lab-pc:8123", 403),
    ):
        asked = {"headers": [("origin", origin)], "host": host, "settings": FAR, "scheme": "https"}
        assert ask("/take/x", "POST", **asked)[0] == status


def test_a_token_s_address_leads_to_this_server_only():
    location = ask("//evil.example/é", query=f"token={TOKEN}", settings=FAR)[1]["location"]
    assert location == "/evil.example/%C3%A9"
    assert token_in_query({"path": "/", "query_string": b"token=a&token=b"}) is None


@pytest.mark.parametrize("cookie", ["", "wrong", TOKEN[:-1], TOKEN + "x", '"', TOKEN.upper()])
def test_without_the_token_nothing_is_answered(cookie):
    for given in ([], [("cookie", f"{COOKIE}={cookie}")]):
        status, headers, body = ask("/", headers=given, settings=FAR)
        assert (status, "error" in json.loads(body)) == (401, True)
        assert "x-own" not in headers
    assert ask("/", query=f"token={cookie}", settings=FAR)[0] == 401
    assert ask("/", "POST", query=f"token={TOKEN}", settings=FAR)[0] == 401


@pytest.mark.parametrize(
    "path", ["/take/abc", "/join/abc", "/feel/abc", "/participants/static/take.js", "/static/studio.css"]
)
def test_participants_and_static_files_need_no_token(path):
    assert ask(path, settings=FAR)[0] == 200


@pytest.mark.parametrize(
    "path",
    ["/take", "/takeover", "/feel", "/edit/file/1/x.ahap", "/make", "/_nicegui_ws/socket.io/", "/static"],
)
def test_all_else_needs_it(path):
    assert ask(path, settings=FAR)[0] == 401


@pytest.mark.parametrize(
    ("path", "most"), [("/take/x/answers", 64 * KIB), ("/make", MIB), ("/_nicegui/client/1", 512 * MIB)]
)
def test_an_announced_body_that_is_too_long_is_refused_before_it_is_read(path, most):
    assert ask(path, "POST", headers=[("content-length", str(most))])[0] == 200
    status, headers, _ = ask(path, "POST", headers=[("content-length", str(most + 1))], app=None)
    assert (status, headers["connection"]) == (413, "close")


def test_a_body_that_grows_too_long_is_refused_as_it_comes():
    pieces = [b"x" * 30 * KIB] * 2
    assert ask("/take/x/answers", "POST", pieces=pieces)[2] == b"61440"
    status, _, body = ask("/take/x/answers", "POST", pieces=pieces * 2)
    assert (status, json.loads(body)["error"]) == (
        413,
        "At most 64 KiB can be sent here; send less.",
    )


def test_an_application_that_answers_in_spite_of_a_refusal_is_not_heard():
    async def careless(scope, receive, send):
        while (await receive())["type"] != "http.disconnect":
            pass
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"yes"})

    assert ask("/take/x", "POST", pieces=[b"x" * 65 * KIB], app=careless)[0] == 413


@pytest.mark.parametrize("headers", [("-1",), ("1", "2"), ("1e3",), ("",), ("9" * 30,)])
def test_lengths_that_are_none_are_refused(headers):
    assert ask(method="POST", headers=[("content-length", text) for text in headers])[0] == 400


def test_two_ways_to_say_a_length_are_refused():
    assert ask(method="POST", headers=[("content-length", "3"), ("transfer-encoding", "chunked")])[0] == 400


def test_a_sender_that_stalls_is_sent_away():
    settings = GuardSettings(body_seconds=0.01)
    status, _, body = ask("/take/x", "POST", headers=CHUNKED, pieces=(), settings=settings)
    assert (status, "stopped arriving" in json.loads(body)["error"]) == (408, True)


def test_a_sender_that_drips_is_sent_away():
    settings = GuardSettings(body_seconds=0.02, body_rate=2000)

    def sent(pieces):
        return ask("/take/x", "POST", headers=CHUNKED, pieces=pieces, every_s=0.001, settings=settings)

    assert sent([b"x"] * 1000)[0] == 408
    # As many pieces, as slowly, but as much as is asked for.
    assert sent([b"x" * 600] * 50)[2] == b"30000"


def test_a_slow_server_cuts_no_answer_to_a_request_without_a_body():
    async def listening(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        # Two messages, as an application that sends a file waits for a disconnect.
        ended = [(await receive())["type"] for _ in range(2)]
        await send({"type": "http.response.body", "body": ",".join(ended).encode()})

    answer = ask(
        pieces=(b"", b""), every_s=0.7, settings=GuardSettings(body_seconds=1.0, body_rate=1e9), app=listening
    )
    assert answer[2] == b"http.request,http.request"


def test_an_error_inside_becomes_one_sentence_and_is_logged(caplog):
    status, headers, body = ask("/broken")
    assert status == 500
    assert b"secret" not in body
    assert "script-src 'self' 'nonce-" in headers["content-security-policy"]
    assert "a secret of the inside" in caplog.text


def test_secrets_of_participants_stand_in_no_log(caplog):
    async def broken(scope, receive, send):
        raise ZeroDivisionError

    ask("/take/SECRET/page", app=broken)
    assert "/take/…/page" in caplog.text
    assert "SECRET" not in caplog.text


def test_every_answer_says_what_a_browser_may_do_with_it():
    headers = ask("/take/x")[1]
    assert headers["content-security-policy"] == PARTICIPANT_POLICY
    assert "unsafe" not in PARTICIPANT_POLICY
    assert "http:" not in PARTICIPANT_POLICY + STUDIO_POLICY
    assert (headers["x-content-type-options"], headers["referrer-policy"]) == ("nosniff", "no-referrer")
    assert headers["cache-control"] == "no-store"
    assert "frame-ancestors 'none'" in STUDIO_POLICY


def test_an_inline_script_needs_the_nonce_of_its_own_response():
    policies = [ask()[1]["content-security-policy"] for _ in range(2)]
    first, second = (re.search(r"'nonce-([\w-]{20,})'", policy)[1] for policy in policies)
    assert first != second
    assert policies[0] == STUDIO_POLICY.format(nonce=first)
    scripts = next(part for part in STUDIO_POLICY.split("; ") if part.startswith("script-src"))
    assert scripts == "script-src 'self' 'nonce-{nonce}' 'unsafe-eval'"


def test_an_answer_s_own_headers_stay():
    async def own(scope, receive, send):
        await send(
            {"type": "http.response.start", "status": 200, "headers": [(b"Cache-Control", b"no-cache")]}
        )
        await send({"type": "http.response.body", "body": b""})

    assert ask(app=own)[1]["cache-control"] == "no-cache"


def test_a_page_is_refused_as_a_page_and_a_sentence_is_text():
    status, headers, body = ask(headers=[("accept", "text/html")], host="<script>")
    assert (status, headers["content-type"]) == (400, "text/html; charset=utf-8")
    status, _, body = ask(method="<B>", headers=[("accept", "text/html")])
    assert (status, b"&lt;B&gt;" in body, b"<B>" in body) == (405, True, False)


def test_a_participants_page_is_refused_in_every_language():
    status, _, body = ask("/take/x", host="elsewhere.example", headers=[("accept", "text/html")])
    assert status == 421
    assert all(complete_texts(language)["no_ticket"] in body.decode() for language in ("en", "ja", "de"))
    _, _, body = ask("/studies", host="elsewhere.example", headers=[("accept", "text/html")])
    assert complete_texts("ja")["no_ticket"] not in body.decode()


def test_a_refused_page_links_to_itself_and_nowhere_else():
    body = ask("//evil.example/'><script>", headers=[("accept", "text/html")], settings=FAR)[2]
    assert b"href='/evil.example/%27%3E%3Cscript%3E'" in body


def websocket(headers, *, texts=(), settings=LOCAL):
    scope = {
        "type": "websocket",
        "path": "/_nicegui_ws/socket.io/",
        "query_string": b"",
        "headers": [
            (name.encode(), value.encode()) for name, value in [("host", "127.0.0.1:8123"), *headers]
        ],
    }
    waiting = [
        {"type": "websocket.connect"},
        *({"type": "websocket.receive", "text": text} for text in texts),
    ]
    waiting.append({"type": "websocket.disconnect"})
    sent = []

    async def receive():
        return waiting.pop(0)

    async def send(message):
        sent.append(message)

    asyncio.run(RequestGuard(echo, settings)(scope, receive, send))
    return sent


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_websocket_of_another_site_is_closed_before_it_opens(origin):
    assert websocket([("origin", origin)]) == [{"type": "websocket.close", "code": 1008}]


def test_a_websocket_needs_the_token_too():
    own = ("origin", "http://127.0.0.1:8123")
    assert websocket([own], settings=FAR)[0]["type"] == "websocket.close"
    assert websocket([own, ("cookie", f"{COOKIE}={TOKEN}")], settings=FAR)[0]["type"] == "websocket.accept"


def test_a_report_is_heard_and_seen_under_its_policy(tmp_path):
    signal = Signal([[0.0, 1.0, 0.0, -1.0]], 100.0, "m/s^2")
    blocks = [ReportFigure(Figure(), "a figure"), ReportSound(signal, "a sound")]
    sections = [ReportSection("All kinds", blocks)]
    path = write_report(tmp_path / "r.html", title="t", summary="s", simulated=True, sections=sections)
    held = dict(re.findall(r'<(\w+)[^>]* src="(\w+):', path.read_text(encoding="utf-8")))
    assert held == {"img": "data", "audio": "data"}
    allowed = {name: sources for name, *sources in (line.split() for line in REPORT_POLICY.split(";"))}
    for kind, directive in (("img", "img-src"), ("audio", "media-src")):
        assert f"{held[kind]}:" in allowed[directive]
