"""Names and texts that are markup, a template, a link or a property: every page shows them, and executes none."""

import json
import re
import shutil
from urllib.parse import quote, unquote

import numpy as np
import pytest

from tactogram.datasets import Recording, create_store
from tactogram.evaluation.report import (
    ReportFigure,
    ReportSection,
    ReportSound,
    ReportTable,
    ReportText,
    write_report,
)
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram_studio.effects.editing import ready_track
from tactogram_studio.effects.effect import Effect
from tactogram_studio.effects.files import SavedEffects
from tactogram_studio.workspace.shelf import ResultArchive
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import shipped_studies
from tactogram_study.workflows.sessions import begin_session

MARKUP = (
    "<img src=x onerror=__xss=1>",
    '"><svg onload=__xss=1>',
    "{{constructor.constructor('__xss=1')()}}",
    'x" :title="__xss=1" x="',
    "x' :title='__xss=1",
    "[a](javascript:__xss=1)",
    "`${__xss=1}`",
)
NAME = "".join(MARKUP)
TEXT = f"{NAME}</script></textarea><script>__xss=1</script>"
TONE = Signal([[0.0, 0.5, 0.0, -0.5] * 500], 1000.0, "1")
PAGES = (
    "",
    "make",
    "touch",
    "edit",
    "materials",
    "train",
    "send",
    "live",
    "studies",
    "reports",
    "nowhere/" + NAME,
)
FILES = re.compile("/touch/|/file/|/result/|/sound|preview")
EXECUTED = "() => 'unset' !== (window.__xss ?? 'unset')"


@pytest.fixture(scope="module")
def workspace(surfaces, tmp_path_factory):
    """Give a workspace in which everything that has a name has this one."""
    folder = tmp_path_factory.mktemp("markup") / "workspace"
    shutil.copytree(surfaces, folder)
    shutil.copytree(folder / "studio/first/voices", folder / f"run {NAME}")
    touched = TONE.with_samples(TONE.samples)
    recording = Recording(
        streams={"acceleration": Signal(touched.samples, 1000.0, "m/s^2")},
        material=TEXT,
        session=TEXT,
        source=TEXT,
    )
    create_store(folder / f"store {NAME}", [recording], name=TEXT, licence=TEXT)
    write_signal(folder / f"{NAME}.wav", TONE)
    write_image(folder / f"{NAME}.png", Image(np.full((9, 9, 3), 99, np.uint8)))
    write_report(folder / f"{NAME}.html", title=TEXT, summary=TEXT, sections=sections(), simulated=TEXT)
    study = shipped_studies()["abx"].read_text(encoding="utf-8")
    study = re.sub(
        r'(?m)^(title\.\w+|names\..*?|consent\.\w+) = ".*"', lambda m: f"{m[1]} = {json.dumps(TEXT)}", study
    )
    (folder / f"{NAME}.toml").write_text(study, encoding="utf-8")
    session = begin_session(folder / f"{NAME}.toml", folder / f"session {NAME}"[:250])
    with SessionStore(session) as store:
        store.enrol("P1")
        store.note(TEXT)
        store.note(TEXT, code="P1")
    for number, text in enumerate((*MARKUP, TEXT[-110:])):
        SavedEffects(folder / "studio" / "effects").add(Effect(title=text, tracks=(ready_track("buzz"),)))
        ResultArchive(folder / "studio" / "kept").keep(
            TONE if number % 2 else Image(np.full((9, 9, 3), 9, np.uint8)),
            title=text,
            facts={"condition": {"material": text}},
        )
    return folder


def sections():
    from matplotlib.figure import Figure

    table = ReportTable([TEXT, "b"], [[TEXT, 1.5]], TEXT, TEXT)
    shown = [ReportText(TEXT), table, ReportFigure(Figure(), TEXT), ReportSound(TONE, TEXT)]
    return [ReportSection(TEXT, shown)]


def executed(page):
    """Return the frames of a page in which something was executed."""
    return [frame.url for frame in page.frames if frame.evaluate(EXECUTED)]


def test_no_name_is_executed_on_any_page(tab, server):
    dialogs, seen = [], set()
    tab.on("dialog", lambda dialog: (dialogs.append(dialog.message), dialog.dismiss()))
    waiting = [f"/{quote(page)}" for page in PAGES]
    while waiting:
        address = waiting.pop(0)
        shape = re.sub(r"\d+|(?<==)[^&]{30,}", "", unquote(address))
        if shape in seen:
            continue
        seen.add(shape)
        tab.goto(address)
        tab.get_by_role("heading", level=1).wait_for()
        if not address.startswith("/live"):  # which asks for news again and again
            tab.wait_for_load_state("networkidle")
        assert executed(tab) == [], address
        assert tab.get_by_text("Unexpected error").count() == 0, address
        assert tab.locator("img[src=x], [onload], [onerror]").count() == 0, address
        links = tab.eval_on_selector_all("a[href]", "links => links.map(link => link.getAttribute('href'))")
        assert not [link for link in links if link.lower().startswith("javascript:")], address
        waiting += [link for link in links if re.match("/[a-z]", link) and not FILES.search(link)]
    assert dialogs == []
    assert len(seen) > 20
    tab.wrong[:] = [line for line in tab.wrong if "nowhere/" not in line and "404" not in line]


def test_an_inline_script_without_the_nonce_is_not_executed(tab):
    tab.goto("/reports")
    tab.evaluate(
        """() => {
          const script = document.createElement('script');
          script.textContent = 'window.__xss = 1';
          document.body.append(script);
          document.body.insertAdjacentHTML('beforeend', '<img src="data:," onerror="window.__xss = 1">');
        }"""
    )
    tab.wait_for_timeout(200)
    assert executed(tab) == []
    assert sum("Content Security Policy" in line for line in tab.wrong) == 2
    tab.wrong.clear()


def test_no_name_is_executed_in_a_report_or_a_page_to_share(tab, workspace, browser, tmp_path):
    key = json.dumps(["file", f"{NAME}.wav", ""])
    rows = json.dumps(
        {"arrangement": TEXT, "rows": [{"key": key, "lay": "auto", "speed": 50.0, "weight": 1.0}]}
    )
    shared = tab.request.get(f"/touch/shared?rows={quote(rows)}")
    assert shared.status == 200, shared.text()
    (tmp_path / "shared.html").write_bytes(shared.body())
    page = browser.new_page()
    for file in (tmp_path / "shared.html", workspace / f"{NAME}.html"):
        page.goto(f"file://{quote(str(file))}")
        page.get_by_text("__xss=1").first.wait_for()
        assert executed(page) == []
    page.close()
