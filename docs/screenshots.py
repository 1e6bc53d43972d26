"""Make the pictures of the pages in docs/studio: prepare a workspace of simulated surfaces, look at each page.

    python docs/screenshots.py [WORKSPACE [PAGE...]]

Needs Chromium and a font with Japanese characters (Debian: chromium, fonts-noto-cjk). What a given WORKSPACE holds
already is not made again.
"""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

HERE = Path(__file__).parent
OUT = HERE / "studio"
DESKTOP, TABLET = {"width": 1440, "height": 900}, {"width": 820, "height": 1180}
LYING = {"width": 1180, "height": 820}
COLOURS = 128
PREPARED = {
    "surfaces": "data simulate stroking9 --out surfaces --per-class 8 --seconds 3 --seed 1",
    "runs/voices": "train ar_texture --data surfaces --out runs/voices",
    "runs/names": "train stroke_cnn --data surfaces --set config.steps=60 --out runs/names",
    "runs/names/report.html": "evaluate runs/names",
    "sessions/two-area": "study simulate two-area --out sessions/two-area --participants 6 --effect d_prime=1",
}
"""What a workspace has to hold, and the verb that makes it."""


def main(workspace: Path, only: Sequence[str] = ()) -> None:
    """Make every picture, or those of some pages."""
    for held, command in PREPARED.items():
        if not (workspace / held).exists():
            print(f"tactogram {command}")
            tactogram(*command.split(), cwd=workspace)
    OUT.mkdir(exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-background-networking"]
        )
        with served("studio", "--folder", ".", prefix="studio: ", cwd=workspace) as address:
            for name, show in PAGES.items():
                if only and name not in only:
                    continue
                for suffix, size in {"": DESKTOP, "-tablet": TABLET}.items():
                    if not suffix or name in ON_A_TABLET:
                        with tab(browser, address, size) as page:
                            show(page)
                            save(page, f"{name}{suffix}")
        if not only or "participants" in only:
            participants(browser, workspace)
        browser.close()


def home(page: Page) -> None:
    """The start page."""
    page.goto("/")
    page.get_by_role("link", name="Make").first.wait_for()


def make(page: Page) -> None:
    """A generated mix, with its class."""
    page.goto("/make")
    page.get_by_role("button", name="Generate", exact=True).click()
    page.locator("canvas").nth(1).wait_for()
    page.wait_for_timeout(3000)


def touch(page: Page) -> None:
    """A simulated hand strokes a surface."""
    page.goto("/touch")
    page.wait_for_selector("#touch[data-ready=true]")
    page.locator("#touch-begin").click()
    page.locator("#touch-hand").click()
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(1500)


def edit(page: Page) -> None:
    """A double tap and a fading buzz, with a point selected."""
    page.goto("/edit")
    page.wait_for_selector("#timeline[data-drawn]")
    for name in ("Double tap", "Buzz", "Fade out"):
        page.get_by_role("button", name=name, exact=True).click()
        page.wait_for_timeout(400)
    page.locator('[data-focus="item 1 amplitude 1"]').click()
    page.wait_for_timeout(800)


def materials(page: Page) -> None:
    """The recordings of a store."""
    page.goto("/materials")
    page.get_by_role("link", name="surfaces", exact=True).click()
    page.wait_for_timeout(5000)


def train(page: Page) -> None:
    """A finished run with its losses."""
    page.goto("/train/watch?run=runs/names")
    page.wait_for_timeout(2500)


def send(page: Page) -> None:
    """A recording on a display, with the report of the fit."""
    page.goto("/send")
    page.get_by_role("combobox", name="From").click()
    page.get_by_role("option", name="Recordings").click()
    page.get_by_role("combobox", name="Recording", exact=True).click()
    page.get_by_role("option").first.click()
    page.get_by_role("button", name="Fit to the display").click()
    page.get_by_role("region", name="Fit report").get_by_role("img").wait_for()
    page.wait_for_timeout(1500)


def live(page: Page) -> None:
    """A simulated sensor, and what it is taken for."""
    page.goto("/live")
    page.wait_for_timeout(9000)  # while it looks for devices
    page.get_by_role("button", name="Listen", exact=True).click()
    page.get_by_text("Hz measured").wait_for()
    page.wait_for_timeout(8500)


def studies(page: Page) -> None:
    """Designs and sessions."""
    page.goto("/studies")
    page.get_by_text("Designs").first.wait_for()
    page.wait_for_timeout(800)


def experiment(page: Page) -> None:
    """What the experimenter sees of a session."""
    page.goto("/experiment/sessions~two-area")
    page.wait_for_timeout(2500)


def reports(page: Page) -> None:
    """A run's report."""
    page.goto("/reports?of=runs/names/report.html")
    page.wait_for_timeout(2000)


def published(page: Page) -> None:
    """Published figures next to ours."""
    page.goto("/reports")
    page.get_by_role("tab", name="Published and ours").click()
    page.wait_for_timeout(1500)


PAGES: dict[str, Callable[[Page], None]] = {
    "home": home,
    "make": make,
    "touch": touch,
    "edit": edit,
    "materials": materials,
    "train": train,
    "send": send,
    "live": live,
    "studies": studies,
    "experiment": experiment,
    "reports": reports,
    "published": published,
}
ON_A_TABLET = ("make", "touch")


def participants(browser: Browser, workspace: Path) -> None:
    """What participants see: joining, a word's scale, two areas with a target, scales of realism."""
    for study, walk in {"two-area": two_areas, "display-words": words}.items():
        session = workspace / "sessions" / "screens"
        shutil.rmtree(session, ignore_errors=True)
        verb = ("study", "run", study, "--out", "sessions/screens")
        with served(*verb, prefix="participants: ", cwd=workspace) as address:
            with tab(browser, address, LYING, touch=True) as page:
                walk(page)
        shutil.rmtree(session)


def joined(page: Page, language: str) -> None:
    """Go through the first pages, up to the first question."""
    page.goto("")
    page.tap(f"button[lang={language}]")
    page.tap(".moment > button.primary")
    page.wait_for_timeout(500)
    save(page, f"participant-joined-{language}")
    page.wait_for_selector(".code-block")
    page.tap("button.primary")
    page.wait_for_selector("form[data-token=consent]")
    answered(page, "agreed")


def answered(page: Page, value: str = "") -> None:
    """Choose an answer where one is given, and go on."""
    token = page.get_attribute("form.page", "data-token")
    if value:
        page.locator("label", has=page.locator(f'input[value="{value}"]')).first.tap()
    page.wait_for_timeout(400)
    page.tap(".foot button")
    page.wait_for_selector(f'form.page:not([data-token="{token}"]), .card-frame, .sound-test')
    if page.locator(".card-frame").count():  # the screen is measured before the first size in millimetres
        page.locator("[role=slider]").focus()
        page.keyboard.press("ArrowRight")
        save(page, "participant-card")
        page.tap("button.primary")
        page.wait_for_selector(".sound-test")
    if page.locator(".sound-test").count():
        page.wait_for_timeout(400)
        page.tap(".moment > button.primary")
    page.wait_for_selector(f'form.page:not([data-token="{token}"])')


def two_areas(page: Page) -> None:
    """The first trial of `two-area`."""
    joined(page, "en")
    answered(page, "right")
    for shot in ("areas", "realism"):
        for area in "AB":
            stroked(page, area)
        page.wait_for_timeout(400)
        save(page, f"participant-{shot}")
        if shot == "areas":
            answered(page, "A")


def stroked(page: Page, area: str) -> None:
    """Move a finger to and fro over an area."""
    box = page.locator(f'[data-area="{area}"]').bounding_box() or {}
    left, right, y = box["x"] + 20, box["x"] + box["width"] - 20, box["y"] + box["height"] / 2
    page.mouse.move(left, y)
    page.mouse.down()
    for stroke in range(12):
        page.mouse.move(left if stroke % 2 else right, y, steps=12)
    page.mouse.up()


def words(page: Page) -> None:
    """The first trial of `display-words`, in Japanese."""
    joined(page, "ja")
    while page.locator("[data-play]").count() == 0:
        answered(page)
    save(page, "participant-words")


@contextlib.contextmanager
def tab(browser: Browser, address: str, size: dict[str, int], *, touch: bool = False) -> Iterator[Page]:
    """Give a page of its own."""
    context = browser.new_context(base_url=address, viewport=size, has_touch=touch)
    context.set_default_timeout(30_000)
    try:
        yield context.new_page()
    finally:
        context.close()


@contextlib.contextmanager
def served(*verb: str, prefix: str, cwd: Path) -> Iterator[str]:
    """Run a verb that serves, and give the address that it prints after ``prefix``."""
    command = [sys.executable, "-m", "tactogram", *verb, "--port", "0", "--no-open"]
    with subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, text=True) as process:
        try:
            for line in process.stdout or ():
                if line.startswith(prefix):
                    yield line.removeprefix(prefix).strip().rstrip("/")
                    break
        finally:
            process.terminate()


def save(page: Page, name: str) -> None:
    """Write a picture in few colours: pages are flat."""
    path = OUT / f"{name}.png"
    page.screenshot(path=path)
    with Image.open(path) as picture:
        picture.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    print(path.relative_to(HERE), f"{path.stat().st_size / 1000:.0f} kB")


def tactogram(*arguments: str, cwd: Path) -> None:
    """Run a verb to its end."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "tactogram", *arguments]
    subprocess.run(command, cwd=cwd, env=environment, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]).resolve(), sys.argv[2:])
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(Path(temporary))  # the pictures show this name; give a WORKSPACE at home for ~/NAME
