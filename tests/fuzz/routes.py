"""Requests made up for every route of both servers, in this process: ``python -m tests.fuzz.routes --seed 1``.

The routes are those of the applications themselves. Their pages are read first, for addresses that exist; what is sent
then is one of those with some parts replaced: path, query, headers, method, body, pieces of the body, or messages of a
websocket. Half of the time goes to the studio, half to the server of a single study, each in a process of its own.

A finding is an answer with a status of 500 or more, an exception or a traceback in the log, a path of this machine or
somebody else's code in an answer, a refusal that is not one line, 20 s without an answer, or 2 GB of memory. It is
printed as a line of JSON, which ``--again LINE`` sends once more. The counts go to ``--out``.
"""

import argparse
import asyncio
import faulthandler
import gzip
import html
import json
import logging
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from urllib.parse import quote, unquote

HANGS_S, MOST_MIB = 20.0, 2048
SERVERS = ("studio", "study")
PARTICIPANTS = ("/join/", "/take/", "/participants/", "/feel/")
ADDRESS = re.compile(r"""["'(=](/[A-Za-z0-9_~%./?=&:+-]*)""")
# fmt: off
NASTY = [
    "", ".", "..", "../../etc/passwd", "..\\..\\x", "/etc/passwd", "//evil.example", "C:\\x", "~", "*", " ", "\t", "\0",
    "a\0b", "a\nb", "a\r\nSet-Cookie: x=1", "\x1b[2J", "\u202egnp.exe", "e\u0301" * 200, "🙂" * 70, "\ufffd", "x" * 255,
    "x" * 256, "x" * 5000, "%", "%00", "%2e%2e%2f", "%ff", "..%2f", "-1", "0", "1.5", "1e999", "nan", "9" * 400, "true",
    "null", "[]", "{}", "{{7*7}}", "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "javascript:alert(1)",
    "' OR 1=1 --", "con", "A", "en", "a/b/c", "https://evil.example/x",
]
VALUES = [None, True, -1, 0, 1e308, 2**70, [], {}, [[]], {"": ""}, [None] * 600, *NASTY]
BODIES = [
    b"", b"{", b"nonsense", b"null", b"\xff\xfe\0", b"[" * 50_000, b'{"a":' * 9000, b'{"token": "\\ud800"}',
    b"x" * 70_000, b"9" * 5000, b'{"a": NaN}',
    b"--x\r\n\r\n", b"PK\x03\x04" + bytes(100), b'{"language": "en", "language": 1}',
]
HEADERS = {
    "accept": ["text/html", "text/markdown", "*/*;q=x", "\xff"], "accept-encoding": ["gzip"],
    "range": ["bytes=0-", "bytes=-1", "bytes=9-1", "bytes=0-1,1-2", "bytes=x", "x" * 5000], "expect": ["100-continue"],
    "cookie": ["tactogram_token=x", "session=x.y.z", "=;=;", "a" * 9000, "\xff=\xff"], "if-none-match": ["*"],
    "content-type": ["text/plain", "application/json; charset=utf-16", "multipart/form-data; boundary=x", "\xff", ""],
    "content-length": ["-1", "1e3", "0", "9" * 12, "x"], "host": ["evil.example", "127.0.0.1:99999", "[::1", ""],
    "origin": ["null", "http://127.0.0.1", "http://[", "\xff"], "sec-fetch-site": ["cross-site"],
    "x-forwarded-for": ["203.0.113.9"], "x-forwarded-prefix": ["//evil.example"], "x-http-method-override": ["PUT"],
    "if-modified-since": ["x"], "accept-language": ["\xff"], "transfer-encoding": ["chunked"], "upgrade": ["websocket"],
}
# fmt: on


@dataclass(frozen=True)
class Made:
    """A request; texts are of latin-1, as they are sent. With messages it is a websocket."""

    target: str
    method: str = "GET"
    headers: tuple[tuple[str, str], ...] = (("host", "127.0.0.1"),)
    pieces: tuple[str, ...] = ()
    messages: tuple[str, ...] | None = None

    def scope(self):
        """Return it as uvicorn gives it to an application."""
        path, _, query = self.target.partition("?")
        kind = "http" if self.messages is None else "websocket"
        scope = {"type": kind, "http_version": "1.1", "path": unquote(path), "query_string": query.encode()}
        scope |= {"headers": [(name.encode(), value.encode("latin-1")) for name, value in self.headers]}
        scope |= (
            {"method": self.method, "scheme": "http"}
            if kind == "http"
            else {"scheme": "ws", "subprotocols": []}
        )
        scope |= {
            "asgi": {"version": "3.0", "spec_version": "2.4"},
            "raw_path": path.encode(),
            "root_path": "",
        }
        return scope | {"client": ("127.0.0.1", 9), "server": ("127.0.0.1", 80), "state": {}}


@dataclass
class Answer:
    """What came back: status, headers and body; of a websocket its messages."""

    status: int = 0
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes = b""


async def ask(app, made):
    """Send a request and return the answer; a client that has said all waits for the end."""
    answer, done = Answer(), asyncio.Event()
    if made.messages is None:
        last = len(made.pieces) - 1
        sent = [
            {"type": "http.request", "body": piece.encode("latin-1"), "more_body": number < last}
            for number, piece in enumerate(made.pieces or ("",))
        ]
    else:
        sent = [
            {"type": "websocket.connect"},
            *({"type": "websocket.receive", "text": text} for text in made.messages),
        ]
        sent.append({"type": "websocket.disconnect", "code": 1000})

    async def receive():
        if sent:
            return sent.pop(0)
        await done.wait()
        return {"type": "http.disconnect"}

    async def send(message):
        if message["type"] == "http.response.start":
            answer.status = message["status"]
            answer.headers = {
                name.decode("latin-1"): value.decode("latin-1") for name, value in message["headers"]
            }
        answer.body += message.get("body", b"") or str(message.get("text") or "").encode("utf-8", "replace")

    faulthandler.dump_traceback_later(2 * HANGS_S, exit=True)  # also where the loop itself is held up
    try:
        await asyncio.wait_for(app(made.scope(), receive, send), HANGS_S)
    finally:
        done.set()
        faulthandler.cancel_dump_traceback_later()
    if answer.headers.get("content-encoding") == "gzip":
        answer.body = gzip.decompress(answer.body)
    return answer


def routes_of(app):
    """Return all routes of an application with what is mounted in it: path, methods (none of a websocket), body."""
    found = []
    for route in app.routes:
        inner = getattr(route, "original_router", None) or getattr(route, "app", None)
        path = getattr(route, "path", "")
        if getattr(inner, "routes", None):
            found += [(path.rstrip("/") + more, methods, body) for more, methods, body in routes_of(inner)]
        elif hasattr(route, "endpoint"):
            body = getattr(getattr(route, "body_field", None), "field_info", None)
            found.append(
                (path, tuple(getattr(route, "methods", None) or ()), getattr(body, "annotation", None))
            )
        else:  # files, or socket.io
            found += [(f"{path}/{{rest:path}}", methods, None) for methods in (("GET", "POST"), ())]
    return list(dict.fromkeys(found))


class Fuzzer:
    """Requests to one application, made up from a seed; ``known`` are values that exist, by name of a parameter."""

    def __init__(self, app, routes, known, *, seed, hidden=()):
        self.app, self.routes, self.known, self.hidden = app, routes, known, hidden
        self.random, self.counts, self.findings, self.logged = random.Random(seed), Counter(), [], []
        self.examples = {}
        handler = logging.Handler(logging.WARNING)
        handler.emit = lambda record: (
            self.logged.append(record) if record.exc_info or record.levelno >= 40 else None
        )
        logging.getLogger().addHandler(handler)

    async def read_pages(self, most=300):
        """Follow the addresses in the pages, for examples of every route."""
        plain = [path for path, methods, _ in self.routes if "GET" in methods and "{" not in path]
        waiting, seen = [*plain, *self.known.get("addresses", ())], set()
        patterns = [
            (route, re.compile(re.sub(r"{\w+:path}", ".*", re.sub(r"{\w+}", "[^/]*", route[0]))))
            for route in self.routes
        ]
        while waiting and len(seen) < most:
            target = waiting.pop(0)
            shape = re.sub(r"\d+|=[^&]*", "", target)
            route = next(
                (route for route, pattern in patterns if pattern.fullmatch(target.partition("?")[0])), None
            )
            if route is None or shape in seen:
                continue
            seen.add(shape)
            self.examples.setdefault(route[0], []).append(target)
            answer = await self.judged(Made(target, headers=(("host", "127.0.0.1"), ("accept", "text/html"))))
            text = html.unescape(answer.body[: 2**20].decode("utf-8", "replace")).replace("\\/", "/")
            waiting += ADDRESS.findall(text)

    def made(self):
        """Return a request: one that exists, with up to three parts replaced."""
        draw = self.random
        path, methods, body = draw.choice(self.routes)
        filled = re.sub(r"{(\w+)(:path)?}", lambda match: self._filled(match[1]), path)
        target = draw.choice([filled, draw.choice(self.examples.get(path, [filled]))])
        headers = [("host", "127.0.0.1")]
        if not methods:
            texts = draw.choices(
                [*self.known["messages"], *NASTY, *map(json.dumps, VALUES)], k=draw.randint(1, 4)
            )
            made = Made(target, headers=tuple(headers), messages=tuple(map(self._changed_text, texts)))
        elif "POST" in methods:
            headers.append(("content-type", "application/json"))
            fields = getattr(body, "model_fields", {"any": None})
            value = {name: self.known[name] for name in fields if name in self.known}
            made = Made(target, "POST", tuple(headers), (json.dumps(value),))
        else:
            made = Made(target, headers=tuple(headers))
        changes = [self._path, self._query, self._header, self._body, self._method]
        for change in draw.choices(changes, (4, 4, 3, 2, 1), k=draw.randint(0, 3)):
            made = change(made)
        return made

    def _filled(self, name):
        return quote(str(self.random.choice(self.random.choice([self.known.get(name) or NASTY, NASTY]))))

    def _path(self, made):
        path, mark, query = made.target.partition("?")
        parts = path.split("/")
        parts[self.random.randrange(len(parts))] = self._quoted()
        return replace(made, target="/" + "/".join(parts).lstrip("/") + mark + query)

    def _query(self, made):
        path, _, query = made.target.partition("?")
        pairs = [
            *filter(None, query.split("&")),
            f"{self.random.choice(self.known['names'])}={self._quoted()}",
        ]
        at = self.random.randrange(len(pairs))
        pairs[at] = pairs[at].partition("=")[0] + "=" + self._quoted()
        return replace(
            made, target=f"{path}?{'&'.join(pairs * self.random.choice((1, 1, 1, 2, 200)))}"[:60_000]
        )

    def _header(self, made):
        name = self.random.choice(list(HEADERS))
        new = (name, self.random.choice(HEADERS[name]))
        kept = [entry for entry in made.headers if entry[0] != new[0] or self.random.random() < 0.1]
        return replace(made, headers=(*kept, new))

    def _method(self, made):
        return replace(
            made, method=self.random.choice(["HEAD", "POST", "PUT", "OPTIONS", "TRACE", "get", "x" * 300])
        )

    def _body(self, made):
        text = made.pieces[0] if made.pieces else ""
        body = self.random.choice([self._changed_text(text), self.random.choice(BODIES).decode("latin-1")])
        size = self.random.choice((1000, 70_000, 1 << 21))
        pieces = tuple(body[at : at + size] for at in range(0, len(body[: 50 * size]), size))
        pieces *= self.random.choice((1, 1, 1, 40))
        return replace(made, method=self.random.choice((made.method, "POST")), pieces=pieces)

    def _changed_text(self, text):
        """Return JSON with a value replaced, removed or added; a text that is none with some characters replaced."""
        draw = self.random
        mark, value = re.fullmatch(r"(\d*)(.*)", text, re.DOTALL).groups()  # socket.io's begin with numbers
        try:
            value = json.loads(value)
        except (ValueError, RecursionError):
            at = draw.randrange(len(text) + 1)
            return text[:at] + draw.choice(NASTY).encode().decode("latin-1") + text[at + draw.randint(0, 3) :]
        held = value
        while isinstance(held, dict | list) and held:
            key = draw.choice(list(held) if isinstance(held, dict) else range(len(held)))
            if isinstance(held[key], dict | list) and draw.random() < 0.6:
                held = held[key]
                continue
            held[key] = draw.choice(VALUES)
            if draw.random() < 0.2:
                del held[key]
            break
        if isinstance(held, dict) and draw.random() < 0.2:
            held[draw.choice(NASTY)] = draw.choice(VALUES)
        return mark + json.dumps(value)

    def _quoted(self):
        text = self.random.choice([*NASTY, *self.known["names"]])
        return self.random.choice(
            [*[quote(text, safe=self.random.choice(("", "/", "/%")))] * 9, "%ed%a0%80%ff"]
        )

    async def judged(self, made):
        """Send a request, count it, and keep what is wrong with the answer."""
        self.logged.clear()
        try:
            answer, wrong = await ask(self.app, made), []
        except TimeoutError:
            answer, wrong = Answer(), [f"no answer in {HANGS_S:g} s"]
        except Exception as error:
            answer, wrong = Answer(), [f"raised {error!r}"]
        self.counts[str(answer.status) if made.messages is None else "websocket"] += 1
        if answer.status >= 500:
            wrong.append(f"status {answer.status}")
        wrong += [
            f"logged {record.getMessage()[:200]} {str(record.exc_info and record.exc_info[1])[:200]}"
            for record in self.logged
        ]
        text = answer.body.decode("utf-8", "replace") + str(answer.headers)
        # The studio's pages are for those who have the folder; refusals and participants' pages are for anybody.
        if answer.status >= 400 or made.target.startswith(PARTICIPANTS):
            told = (secret for secret in self.hidden if secret in text and secret not in str(made))
            wrong += [f"told {secret}" for secret in told]
        if "Traceback (most" in text:
            wrong.append("told a traceback")
        page = made.method == "HEAD" or "html" in answer.headers.get("content-type", "")
        if answer.status >= 400 and not page:
            line = answer.body.decode("utf-8", "replace").strip()
            if not 5 < len(line) < 1000 or "\n" in line:
                wrong.append(f"status {answer.status} without one line: {line[:100]!r}")
        mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        if mib > MOST_MIB > self.counts["MiB"]:
            wrong.append(f"took {mib} MiB")
        self.counts["MiB"] = mib
        if wrong:
            self.findings.append({"wrong": wrong, "request": asdict(made)})
            sys.stderr.write(json.dumps(self.findings[-1]) + "\n")
        return answer


def make_workspace(folder):
    """Fill a folder with something for every page."""
    import numpy as np

    from tactogram.datasets import Recording, create_store
    from tactogram.signal import Image, Signal
    from tactogram.signal.io import write_image, write_signal
    from tactogram.workflows.training.train import train
    from tactogram_simulate import simulate_to_store
    from tactogram_study.session.store import SessionStore
    from tactogram_study.workflows.sessions import begin_session

    simulate_to_store(
        "stroking9", folder / "studio/first/surfaces", seed=0, per_class=2, seconds=1.0, workers=1
    )
    train("ar_texture", folder / "studio/first/surfaces", split="all", out=folder / "studio/first/voices")
    tone = Signal([[0.0, 1.0, 0.0, -1.0] * 300], 1000.0, "m/s^2")
    create_store(
        folder / "tones",
        [Recording(streams={"acceleration": tone}, material="tone", source="a.wav")],
        name="tones",
        licence="made here",
    )
    write_signal(folder / "tone.wav", replace(tone, unit="1"))
    write_image(folder / "picture.png", Image(np.full((4, 4, 3), 99, np.uint8)))
    (folder / "report.html").write_text("<h1>A report</h1>")
    session = begin_session("abx", folder / "pilot", changes={"design.repeats": 4, "grid.items": ["tile"]})
    with SessionStore(session) as store:
        for code in ("P1", "HIDDEN7CODE"):
            store.enrol(code)
        store.submit("P1", "consent", {"consent": "agreed"})


async def fuzz(server, folder, *, seed, seconds, again=None):
    """Fuzz one server on a workspace for some time, and return what was counted and found."""
    from tactogram_studio.application import make_app
    from tactogram_studio.context import Studio
    from tactogram_study.participants import routes

    routes.WRONG_CODE_S = 0.0
    studio = Studio.at(folder, study_only=server == "study")
    session = studio.sessions.open(folder / "pilot")
    app = make_app(studio)
    ticket, known_routes = session.keys.ticket("P1"), routes_of(app.app)
    parameters = {name for path, *_ in known_routes for name in re.findall(r"{(\w+)", path)}
    files = [str(path.relative_to(folder)) for path in sorted(folder.rglob("*")) if path.is_file()][:40]
    names = {
        *parameters,
        *files,
        "of",
        "set",
        "id",
        "key",
        "run",
        "tab",
        "q",
        "token",
        "slot",
        "where",
        "stream",
    }
    pages = [session.join_path, f"{session.join_path}/study", f"/take/{ticket}/page", "/experiment/pilot"]
    known = {
        "ticket": [ticket],
        "session": ["pilot"],
        "key": [session.keys.join, *files[:5]],
        "name": files,
        "names": sorted(names),
        "addresses": pages,
        **{"language": "en", "slot": "A", "code": "P1", "token": "trial-1.1", "answers": {"which": "A"}},
        "messages": [
            '{"slot": "A", "samples": [[1.0, 2.0, 3.0, 1.0]]}',
            *("0", "2probe", "40", "41", "3", '42["handshake",{"client_id":"x","tab_id":"y"}]', "451-[]"),
            '42["event",{"id":4,"client_id":"x","listener_id":"y","args":[1]}]',
            '42["javascript_response",{"request_id":"x","client_id":"x","result":1}]',
        ],
    }
    fuzzer = Fuzzer(
        app, known_routes, known, seed=seed, hidden=(str(folder), str(Path(sys.prefix)), "HIDDEN7CODE")
    )
    begun = time.monotonic()
    async with app.app.router.lifespan_context(app.app):
        if again is not None:
            await fuzzer.judged(again)
        else:
            await fuzzer.read_pages()
        while again is None and time.monotonic() < begun + seconds:
            made, page = fuzzer.made(), session.store.page("P1")
            known["token"] = page.token if page else ""
            (folder.parent / f"last-{server}.json").write_text(json.dumps(asdict(made)))
            await fuzzer.judged(made)
    studio.sessions.close()
    mib = fuzzer.counts.pop("MiB", 0)
    counted = {
        "requests": fuzzer.counts.total(),
        "routes": len(known_routes),
        "examples": len(fuzzer.examples),
    }
    return {
        **counted,
        "MiB": mib,
        "answers": dict(sorted(fuzzer.counts.items())),
        "findings": fuzzer.findings,
    }


def main(arguments=None):
    """Run the fuzzer; return 1 if it found something."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.routes", description=__doc__.split(":", 1)[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--server", choices=SERVERS, action="append")
    parser.add_argument("--out", type=Path, help="file for the counts, as JSON")
    parser.add_argument("--again", help="a finding, to send its request once more")
    parser.add_argument("--child", type=Path, help=argparse.SUPPRESS)
    a = parser.parse_args(arguments)
    servers = a.server or SERVERS
    if a.child:
        again = json.loads(a.again) if a.again else None
        request = again and Made(
            **{k: tuple(map(tuple, v)) if k == "headers" else v for k, v in again["request"].items()}
        )
        found = asyncio.run(fuzz(servers[0], a.child, seed=a.seed, seconds=60 * a.minutes, again=request))
        sys.stdout.write(json.dumps(found) + "\n")
        sys.stdout.flush()
        os._exit(0)  # whatever still waits
    result = {}
    for server in servers:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary).resolve() / "workspace"
            folder.mkdir()
            make_workspace(folder)
            child = ["--child", str(folder), "--server", server, "--seed", str(a.seed)]
            child += ["--minutes", str(a.minutes / len(servers)), *(["--again", a.again] if a.again else [])]
            run = subprocess.run(
                [sys.executable, "-m", "tests.fuzz.routes", *child],
                check=False,
                stdout=subprocess.PIPE,
                text=True,
            )
            if run.returncode or not run.stdout:
                last = json.loads((folder.parent / f"last-{server}.json").read_text())
                ended = {"wrong": [f"the process ended with {run.returncode}"], "request": last}
                run.stdout = json.dumps({"requests": 0, "findings": [ended]})
            result[server] = {"seed": a.seed, **json.loads(run.stdout.splitlines()[-1])}
    text = json.dumps(result, indent=1) + "\n"
    sys.stdout.write(text)
    if a.out:
        a.out.write_text(text)
    return int(any(found["findings"] for found in result.values()))


if __name__ == "__main__":
    sys.exit(main())
