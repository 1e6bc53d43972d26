"""A browser, a studio served to it, and pages that fail a test on any error in them."""

import contextlib
import fcntl
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlsplit

import pytest

sys.path.append(str(Path(__file__).parent))  # laboratory_files

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--autoplay-policy=user-gesture-required",
    "--host-resolver-rules=MAP tablet.test 127.0.0.2",  # a name that browsers do not trust like localhost
)


# Not for the session: Playwright keeps an event loop running, and tests of other modules may need their own.
@pytest.fixture(scope="module")
def browser():
    """Give the system's Chromium, driven by Playwright."""
    found = os.environ.get("TACTOGRAM_BROWSER") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if not found:
        pytest.skip(
            "no browser: install Chromium (Debian: apt install chromium), or name one in TACTOGRAM_BROWSER"
        )
    playwright = pytest.importorskip("playwright.sync_api").sync_playwright().start()
    opened = playwright.chromium.launch(executable_path=found, args=list(QUIET))
    yield opened
    opened.close()
    playwright.stop()


@contextlib.contextmanager
def served(*arguments: str, folder: Path, prefix: str):
    """Run a serving verb, and give its process and the address that it prints after ``prefix``."""
    with (folder / "server.log").open("ab") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "tactogram", *arguments],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "default"},
            start_new_session=True,
        )
    try:
        for line in process.stdout:
            if line.startswith(prefix):
                yield process, line.removeprefix(prefix).strip().rstrip("/")
                break
        else:
            pytest.fail((folder / "server.log").read_text())
    finally:
        if process.poll() is None:
            # Killed, which takes no time, unless it has coverage to write first.
            measured = "COVERAGE_PROCESS_CONFIG" in os.environ
            os.killpg(process.pid, signal.SIGINT if measured else signal.SIGKILL)
        process.wait(60)
        process.stdout.close()


@pytest.fixture(scope="session")
def surfaces(tmp_path_factory):
    """Give a workspace with a small simulated store and a run of autoregressive textures (`studio/first`).

    It is made once for all workers of pytest-xdist; the others wait.
    """
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "surfaces"
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.is_dir():
            part = folder.with_suffix(f".{os.getpid()}")
            _make_surfaces(part / "studio" / "first")
            part.rename(folder)
    return folder


def _make_surfaces(first: Path) -> None:
    from tactogram.workflows.training.train import train
    from tactogram_simulate import simulate_to_store

    simulate_to_store("stroking9", first / "surfaces", seed=0, per_class=2, seconds=1.0, workers=1)
    train("ar_texture", first / "surfaces", split="all", out=first / "voices")


@pytest.fixture(scope="module")
def workspace(surfaces, tmp_path_factory):
    """Give a copy of `surfaces` to each module."""
    folder = tmp_path_factory.mktemp("studio") / "workspace"
    shutil.copytree(surfaces, folder)
    return folder


@pytest.fixture(scope="module")
def server(workspace):
    """Give the address of a studio on `workspace`."""
    with served(
        "studio", "--port", "0", "--no-open", "--folder", ".", folder=workspace, prefix="studio: "
    ) as (_, address):
        yield address


PATIENCE_MS = 60_000
"""Long enough for a busy machine; only a page that hangs fails."""
UNHEARD = """() => {
  if (window !== window.top) return;
  const hiding = new CSSStyleSheet();
  hiding.replaceSync('html { visibility: hidden }');
  // Before the scripts that draw it; never where scripts are not allowed.
  document.addEventListener('readystatechange', () => { document.adoptedStyleSheets = [hiding]; }, {once: true});
  addEventListener('DOMContentLoaded', () => {
    const timer = setInterval(() => {
      if (window.io && !window.did_handshake) return;
      clearInterval(timer);
      document.adoptedStyleSheets = [];
      window.heard = true;
    }, 20);
    window.notices = [];
    new MutationObserver((changes) => {
      for (const { addedNodes } of changes) {
        for (const node of addedNodes) {
          if (node.classList?.contains('q-notification')) window.notices.push(node.innerText);
        }
      }
    }).observe(document.body, {childList: true, subtree: true});
  });
}"""
"""Hides a page until it is connected to the server, so that Playwright, like a person, cannot act on it earlier.

NiceGUI queues earlier actions, and may send them in another order. The script also collects notifications, which a
failing test reports.
"""


def heard(page, go):
    """Return ``page.goto`` or ``page.reload`` that waits until the page is connected to the server."""

    def gone(*args, **kwargs):
        answer = go(*args, **kwargs)
        page.wait_for_function("() => window.heard || location.protocol === 'about:'")
        return answer

    return gone


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Report the text and notifications of the page of a failed test."""
    report = yield
    values = getattr(item, "funcargs", {})
    page = values.get("tab") or values.get("page")
    if call.when == "call" and report.failed and page is not None:
        with contextlib.suppress(Exception):  # the page itself may be broken
            report.sections.append((f"page {page.url}", page.locator("body").inner_text(timeout=2000)))
            report.sections.append(("notifications", str(page.evaluate("window.notices"))))
            report.sections.append(
                ("connections closed", f"{page.closed_connections}: what is clicked then is lost")
            )
    return report


@contextlib.contextmanager
def watched(context, address):
    """Give a page of ``context``; fail on its errors, and on requests to other hosts."""
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    page.emulate_media(reduced_motion="reduce")  # a click may miss what moves
    page.add_init_script(f"({UNHEARD})()")
    page.closed_connections = 0

    def count_closed(_):
        page.closed_connections += 1

    page.on("websocket", lambda connection: connection.on("close", count_closed))
    wrong = []
    page.on("pageerror", lambda error: wrong.append(f"error in the page: {error}"))
    page.on(
        "console",
        lambda entry: (
            wrong.append(f"console: {entry.text} {entry.location}") if entry.type == "error" else None
        ),
    )
    host = urlsplit(address).netloc
    page.on(
        "request",
        lambda request: (
            None
            if request.url.startswith(("data:", "blob:")) or urlsplit(request.url).netloc == host
            else wrong.append(f"request to {request.url}")
        ),
    )
    page.wrong = wrong
    page.goto, page.reload = heard(page, page.goto), heard(page, page.reload)
    yield page
    assert wrong == []


@pytest.fixture(scope="module")
def window(browser, server):
    """Give a browser context on the studio that keeps compiled scripts: compiling them takes half of a visit."""
    context = browser.new_context(base_url=server, viewport={"width": 1440, "height": 900})
    yield context
    context.close()


@pytest.fixture
def tab(window, server):
    """Give a page on the studio to a new visitor; expected errors are cleared with ``tab.wrong.clear()``."""
    with watched(window, server) as page:
        yield page
    page.goto("about:blank")
    kept = {"origin": server, "storageTypes": "cookies,local_storage"}
    window.new_cdp_session(page).send("Storage.clearDataForOrigin", kept)
    page.close()


@pytest.fixture(scope="session", name="served")
def served_fixture():
    """Give `served`, for other verbs and folders."""
    return served


@pytest.fixture(scope="session", name="watched")
def watched_fixture():
    """Give `watched`, for other contexts."""
    return watched


@pytest.fixture(scope="session")
def faults():
    """Give a function that returns what axe-core finds on a page, one line for each element."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()

    def found(page):
        rules = {"label-content-name-mismatch": {"enabled": True}}  # experimental, hence off by default
        violations = axe.run(page, options={"rules": rules}).response["violations"]
        nodes = [(rule["id"], node) for rule in violations for node in rule["nodes"]]
        return [f"{name}: {node['html']} {node['failureSummary']}" for name, node in nodes]

    return found


@pytest.fixture
def tones(tmp_path):
    """A store of four tones, of which one has another rate."""
    from laboratory_files import tone

    from tactogram.datasets import Recording, create_store

    made = (
        Recording(
            streams={"acceleration": tone(hz, rate=rate)},
            material=f"tone-{hz}",
            speed_mm_s=float(hz),
            session=f"day {number % 2}",
            source=f"tones/{number}.wav",
        )
        for number, (hz, rate) in enumerate([(50, 1000.0), (100, 1000.0), (200, 1000.0), (100, 2000.0)])
    )
    return create_store(tmp_path / "tones", made, name="tones", licence="made in a test")


SHORT = {"design.repeats": 4, "practice": {"trials": 1}, "grid.items": ["tile"]}


@pytest.fixture
def session(tmp_path):
    """Give a session of a short ABX study: P1 is at its third trial, P2 reads the consent."""
    from tactogram_study.session.store import SessionStore
    from tactogram_study.workflows.sessions import begin_session

    folder = begin_session("abx", tmp_path / "sessions" / "pilot", changes=SHORT)
    with SessionStore(folder) as store:
        for code in ("P1", "P2"):
            store.enrol(code)
        store.submit("P1", "consent", {"consent": "agreed"}, device={"px_per_mm": 6.25, "refresh_hz": 59.94})
        for token in ("practice-1.1", "trial-1.1", "trial-2.1"):
            store.submit(
                "P1", token, {"which": "A"}, device={"finger_speed_mm_s_a": 480.2, "finger_speed_mm_s_b": 510}
            )
        yield store
