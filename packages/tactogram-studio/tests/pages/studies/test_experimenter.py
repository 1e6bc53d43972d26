import contextlib
import signal
import sqlite3
import zipfile
from urllib.parse import unquote, urlsplit

import pytest

from tactogram.cli import main
from tactogram_studio.server.listening import svg_qr_code
from tactogram_study.session.store import SessionStore

LISTENING = ("--host", "0.0.0.0", "--port", "0", "--https", "--no-open")
"""For other machines: the address that is printed has a token, which the browser takes to the page."""
SETS = ("design.repeats=4", "practice.trials=1", 'grid.items=["tile"]')
ANSWERED = "fetch('/static/studio.css', {signal: AbortSignal.timeout(10000)}).then(answer => answer.status)"
UNNAMED = """() => [...document.querySelectorAll('button, a, input, textarea, select')].filter(e => {
    if (e.closest('[aria-hidden=true]') || e.type === 'hidden' || !e.offsetParent) return false;
    const label = e.labels && [...e.labels].map(l => l.textContent).join('');
    return !((e.getAttribute('aria-label') || e.textContent || label || e.title || '').trim());
}).map(e => e.outerHTML.slice(0, 120))"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return tmp_path_factory.mktemp("lab")


def running(served, lab, *more):
    changed = [word for value in SETS for word in ("--set", value)]
    return served(
        "study", "run", "abx", "--out", "pilot", *LISTENING, *changed, *more,
        folder=lab, prefix="experimenter: ",
    )  # fmt: skip


def answer(store, code, *tokens):
    for token in tokens:
        key = "consent" if token == "consent" else "which"
        device = {"px_per_mm": 6.25} if token == "consent" else {"finger_speed_mm_s": 490}
        value = "agreed" if token == "consent" else "A"
        assert store.submit(code, token, {key: value}, device=device).stored


@pytest.fixture(scope="module")
def started(served, lab):
    with running(served, lab, "--participants", "P1,P2") as process_and_address:
        yield process_and_address


@pytest.fixture
def page(browser, watched, started):
    process, address = started
    context = browser.new_context(
        viewport={"width": 1440, "height": 900}, accept_downloads=True, ignore_https_errors=True
    )
    with watched(context, address) as opened:
        opened.goto(address)
        opened.process, opened.address = process, address
        yield opened
    context.close()


def yes(page, button):
    page.get_by_role("dialog").get_by_role("button", name=button).click()
    page.get_by_role("dialog").wait_for(state="hidden")


def test_the_experimenter_follows_helps_stops_and_exports(page, lab):
    row = page.get_by_role("row", name="P1")
    with SessionStore(lab / "pilot") as store:
        page.get_by_text("2 participants, 2 not begun; 0 answers").wait_for()
        answer(store, "P1", "consent", "practice-1.1", "trial-1.1")
        row.get_by_text("trial 2 of 4").wait_for()
        row.get_by_text("6.25 px/mm, finger 490 mm/s").wait_for()

        code = page.get_by_label("Code (empty: random)")
        code.fill("K7")
        page.get_by_role("button", name="Enrol").click()
        taken = page.get_by_role("link", name="Open their pages").get_attribute("href")
        assert "/take/" in taken
        page.wait_for_function("field => field.value === ''", arg=code.element_handle())
        code.fill("Hanako")
        page.get_by_role("button", name="Enrol").click()
        page.get_by_text("never a name").wait_for()

        page.get_by_role("button", name="QR code K7").click()
        shown = page.get_by_role("dialog").get_by_role("img", name="QR code: Address of the pages of K7")
        assert unquote(shown.get_attribute("src")) == unquote(svg_qr_code(taken))
        page.get_by_role("dialog").get_by_role("button", name="Close").click()
        page.get_by_role("dialog").wait_for(state="detached")

        page.get_by_role("textbox", name="Note").fill("The fan was on")
        page.get_by_role("button", name="Add note").click()
        page.get_by_text("the study: The fan was on").wait_for()

        with contextlib.closing(sqlite3.connect(store.path, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")  # another program writes for long
            page.get_by_role("textbox", name="Note").fill("The fan was off")
            page.get_by_role("button", name="Add note").click()
            assert page.evaluate(ANSWERED) == 200  # nobody else waits with who clicked
        page.get_by_text("the study: The fan was off").wait_for()

        row.get_by_role("button", name="Abort").click()
        yes(page, "Abort")
        row.get_by_text("aborted").wait_for()
        assert store.state("P1") == "aborted"
        row.get_by_role("button", name="Reopen").click()
        row.get_by_text("going on").wait_for()

        page.get_by_role("button", name="Withdraw P2").click()
        store.enrol("P9")
        page.locator("tr", has_text="P9").wait_for()  # who joins meanwhile takes no question away
        page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
        page.get_by_role("row", name="P2").wait_for()
        page.get_by_role("button", name="Withdraw P2").click()
        yes(page, "Delete P2")
        page.get_by_role("row", name="P2").wait_for(state="detached")
        assert (store.withdrawn, [one.code for one in store.participants()]) == (1, ["P1", "K7", "P9"])

        page.get_by_role("button", name="Analyse").click()
        page.get_by_text("finds differences by chance more often than alpha says").wait_for()
        yes(page, "Cancel")
        with page.expect_download() as download:
            page.get_by_role("button", name="Download tables").click()
        with zipfile.ZipFile(download.value.path()) as packed:
            assert b"The fan was on" in packed.read("pilot-tables/answers.notes.csv")
            assert b"P2" not in packed.read("pilot-tables/answers.participants.csv")

        page.get_by_role("button", name="End the study").click()
        yes(page, "End the study")
        page.get_by_text("Ended: nobody can join").wait_for()
        assert store.ended
        page.get_by_role("button", name="Continue the study").click()
        page.get_by_text("Ended: nobody can join").wait_for(state="hidden")

    assert page.evaluate(UNNAMED) == []
    page.set_viewport_size({"width": 820, "height": 1180})
    assert page.evaluate("document.documentElement.scrollWidth") <= 820


def test_simulated_participants_take_it_beside_and_are_analysed(page, lab):
    page.get_by_text("Simulated participants").click()
    page.get_by_label("How many").fill("6")
    page.get_by_label("True effect").fill("d_prime=4")
    page.get_by_role("button", name="Simulate", exact=True).click()
    page.get_by_role("link", name="6 simulated participants finished").click()
    page.get_by_text("6 simulated participants, 6 finished").wait_for()
    assert page.get_by_text("Take part", exact=True).is_hidden()
    page.get_by_role("button", name="Analyse").click()
    with page.context.expect_page() as opened:
        page.get_by_role("link", name="Open the new report").click()
    opened.value.get_by_text("Simulated participants: programs answered").wait_for()
    assert opened.value.get_by_role("heading", name="Notes of the experimenter").count() == 0
    assert (lab / "pilot-simulated" / "analysis" / "report.html").is_file()


def test_what_is_no_session_is_told(page):
    page.goto(page.address.replace("/experiment/pilot", "/experiment/nothing"))
    page.get_by_role("alert").filter(has_text="no study was begun here").wait_for()
    page.goto(page.address.replace("/experiment/pilot", "/experiment/..~..~etc"))
    page.get_by_role("alert").filter(has_text="lies outside of the workspace").wait_for()


def test_a_port_that_cannot_be_had_begins_no_study_and_leaves_nothing(page, lab, capsys, monkeypatch):
    folder = lab / "elsewhere"
    folder.mkdir()
    monkeypatch.chdir(folder)
    port = str(urlsplit(page.address).port)
    for verb in (("study", "run", "abx", "--out", "new/pilot"), ("studio", "--folder", "new")):
        for more, told in (
            (
                ("--host", "127.0.0.2", "--port", port),
                f"cannot listen on port {port} of 127.0.0.2 (Address already in use)",
            ),
            (
                ("--host", "203.0.113.9", "--port", "0"),
                "of 203.0.113.9 (Cannot assign requested address)",
            ),
            (("--certificate", "no.pem"), "no.pem: no such file; expected the certificate in PEM format"),
            (("--key", "no.pem"), "key needs certificate, got only key; give both"),
        ):
            assert main([*verb, "--no-open", *more]) == 1
            said = capsys.readouterr()
            assert (said.out, said.err.count("\n"), told in said.err) == ("", 1, True)
    assert list(folder.iterdir()) == []


# Last: it ends the server of the others.
def test_ctrl_c_ends_it_in_a_line_and_run_again_it_goes_on(page, served, lab):
    kept = (lab / "studio" / "state" / "https.pem").read_bytes()
    join = page.get_by_role("link", name="Address to take part").get_attribute("href").rpartition("/")[2]
    with SessionStore(lab / "pilot") as store:
        known = [one.code for one in store.participants()]
    page.goto("about:blank")
    page.process.send_signal(signal.SIGINT)
    assert page.process.wait(timeout=60) == 0
    said = (lab / "server.log").read_text().splitlines()
    assert said[-1] == "tactogram: the study's server ended; all answers are stored"
    assert not [line for line in said if "Traceback" in line or "Error" in line]
    again = ("study", "run", "pilot", *LISTENING)
    with served(*again, folder=lab, prefix="experimenter: ") as (process, _):
        assert join in process.stdout.readline()
    assert (lab / "studio" / "state" / "https.pem").read_bytes() == kept
    with SessionStore(lab / "pilot") as store:
        assert [one.code for one in store.participants()] == known
