"""Simulated participants in a real browser: each has a window, and answers its pages by the events that a hand causes.

The page's clock runs faster than the wall's: a target is followed and a stimulus is played in less time. What is
answered is computed by the pure `study.sitting.next_page`; nothing of it is read from the page.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, DeviceError
from tactogram.extras import imported
from tactogram_study.session.progress import next_page
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import SimulatedParticipant
from tactogram_study.study_file import Study
from tactogram_study.trials import PageAnswers, Participant

HAND = Path(__file__).with_name("browser_hand.js")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
CLOCK = 10
"""How many times faster the pages' clock runs than the wall's."""
STROKE_MS = 1100
"""How long an area is stroked, by the page's clock."""
FASTER = """(() => {
  const times = %d, now = performance.now.bind(performance), later = window.setTimeout.bind(window);
  const frame = window.requestAnimationFrame.bind(window);
  performance.now = () => times * now();
  window.setTimeout = (f, ms = 0, ...more) => later(f, ms / times, ...more);
  window.requestAnimationFrame = (f) => frame((ms) => f(times * ms));
  Object.defineProperty(Event.prototype, "timeStamp", { get: () => performance.now() });
  Element.prototype.setPointerCapture = () => {};
  Element.prototype.hasPointerCapture = () => true;
})()"""
AWAY = ("ERR_CONNECTION", "ERR_EMPTY_RESPONSE", "chrome-error:", "Not attached to an active page")
"""How a browser says that no server is there."""
PAGE_MS = 120_000
TRIES = 5
"""How often a hand tries a page that says that something is missing: a stroke may be lost where a machine is busy."""
FIRST_MS = 15_000


class StudyServer:
    """``tactogram study run`` as a process, at the same address after it was killed.

    Parameters
    ----------
    folder : Path
        Of the session.
    codes : sequence of str
        Of participants that are enrolled.
    changes : sequence of str
        ``KEY=VALUE`` each.
    """

    def __init__(self, study: str, folder: Path, codes: Sequence[str], changes: Sequence[str]) -> None:
        self.study, self.folder, self.codes, self.changes = study, folder, list(codes), list(changes)
        self.port = 0
        self.process: subprocess.Popen[str] | None = None
        self.addresses: dict[str, str] = {}
        self.join = ""

    def start(self) -> None:
        """Start it and wait until it answers.

        Raises
        ------
        DataError
            If it ends instead; its log is beside the session.
        """
        log = self.folder.with_name(f"{self.folder.name}.log")
        changes = [part for change in self.changes for part in ("--set", change)]
        with log.open("ab") as told:
            self.process = subprocess.Popen(
                [
                    *(sys.executable, "-m", "tactogram", "study", "run", self.study),
                    *("--out", str(self.folder), "--port", str(self.port), "--no-open", "--json"),
                    *("--participants", ",".join(self.codes), *changes),
                ],
                stdout=subprocess.PIPE,
                stderr=told,
                text=True,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
                start_new_session=True,
            )
        if self.process.stdout is None:
            raise DataError("the server's output cannot be read")
        text = ""
        for line in self.process.stdout:
            text += line
            try:
                facts = json.loads(text)
            except ValueError:
                continue
            self.addresses, self.join = facts["codes"], facts["join"]
            self.port = int(self.join.split(":")[2].split("/")[0])
            return
        raise DataError(f"the study's server ended at once; see {log}")

    def kill(self) -> None:
        """Kill it by SIGKILL, and all that it started."""
        if self.process is None:
            return
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        if self.process.stdout is not None:
            self.process.stdout.close()


@dataclass
class Sitting:
    """What came of all participants' sittings.

    Parameters
    ----------
    pages : int
        Answered.
    reloads : int
        Pages that were loaded anew after the server had been killed.
    killed : int
        How often the server was.
    wrong : list of str
        Errors in pages.
    refused : list of str
        What pages said was still missing; the hand then tried again.
    given : dict
        Answers in the order of the page's questions, by code and token.
    """

    pages: int = 0
    reloads: int = 0
    killed: int = 0
    wrong: list[str] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    given: dict[tuple[str, str], list[str]] = field(default_factory=dict)


def browser_path() -> str:
    """Return the system's Chromium.

    Raises
    ------
    DeviceError
        If there is none.
    """
    found = os.environ.get("TACTOGRAM_BROWSER") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if not found:
        raise DeviceError("no browser: install Chromium, or name one in TACTOGRAM_BROWSER")
    return found


def take_all(
    server: StudyServer,
    study: Study,
    who: Sequence[Participant],
    effect: SimulatedEffect,
    *,
    seed: int = 0,
    at_once: int = 4,
    kill_at: int | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> Sitting:
    """Let simulated participants take a study in the browser, at most ``at_once`` at the same time.

    Parameters
    ----------
    server : StudyServer
        Started.
    kill_at : int, optional
        After so many pages of all, the server is killed by SIGKILL in the midst of answers, and started again. Every
        second participant then loads the page anew; the others wait until the page has sent its answer by itself.
    """
    return asyncio.run(_take_all(server, study, who, effect, seed, at_once, kill_at, progress))


async def _take_all(
    server: StudyServer,
    study: Study,
    who: Sequence[Participant],
    effect: SimulatedEffect,
    seed: int,
    at_once: int,
    kill_at: int | None,
    progress: Callable[[str], None],
) -> Sitting:
    playwright = imported("playwright.async_api", extra="dev", what="simulated participants in a browser")
    sitting, room, killing = Sitting(), asyncio.Semaphore(at_once), asyncio.Lock()
    killed = asyncio.Event()

    async def answered() -> None:
        sitting.pages += 1
        if sitting.pages % 100 == 0:
            progress(f"{study.name}: {sitting.pages} pages")
        if kill_at is not None and sitting.pages >= kill_at and not killed.is_set():
            async with killing:
                if not killed.is_set():
                    killed.set()
                    sitting.killed += 1
                    server.kill()
                    await asyncio.sleep(0.5)
                    await asyncio.to_thread(server.start)

    async with playwright.async_playwright() as driver:
        browser = await driver.chromium.launch(
            executable_path=browser_path(),
            args=["--no-sandbox", "--disable-gpu", "--autoplay-policy=no-user-gesture-required"],
        )
        try:

            async def one(participant: Participant) -> None:
                async with room:
                    simulated = SimulatedParticipant(effect, (seed, participant.number))
                    taker = _Taker(browser, server, study, participant, simulated, sitting)
                    await taker.take(answered, killed)

            async with asyncio.TaskGroup() as tasks:
                for participant in who:
                    tasks.create_task(one(participant))
        finally:
            await browser.close()
    return sitting


class _Taker:
    """One simulated participant at one window."""

    def __init__(
        self,
        browser: Any,
        server: StudyServer,
        study: Study,
        participant: Participant,
        simulated: SimulatedParticipant,
        sitting: Sitting,
    ) -> None:
        self.browser, self.server, self.study, self.participant = browser, server, study, participant
        self.simulated, self.sitting = simulated, sitting
        self.given: list[PageAnswers] = []

    async def take(self, answered: Callable[[], Any], killed: asyncio.Event) -> None:
        context = await self.browser.new_context(
            viewport={"width": 820, "height": 1180}, has_touch=True, locale="ja-JP"
        )
        await context.add_init_script(FASTER % CLOCK)
        tab = await context.new_page()
        tab.set_default_timeout(PAGE_MS)
        tab.on("pageerror", lambda error: self.sitting.wrong.append(f"{self.participant.code}: {error}"))
        try:
            address = self.server.addresses[self.participant.code]
            await self._reach(lambda: tab.goto(address))
            await self._begin(tab)
            was_killed = killed.is_set()
            hand = HAND.read_text(encoding="utf-8").partition("\n")[2]
            while (page := next_page(self.study, self.participant, self.given)) is not None:
                await self._moments(tab, page.token)
                answers = self.simulated.answer(page)
                for _ in range(TRIES):
                    why = await tab.evaluate(hand, {"answers": answers, "strokeMs": STROKE_MS})
                    if not why:
                        break
                    self.sitting.refused.append(f"{self.participant.code}, {page.token}: {why}")
                else:
                    raise DataError(f"{self.sitting.refused[-1]} ({TRIES} times)")
                accepted = page.accepted(answers)
                self.given.append(PageAnswers(page.token, accepted, page.more))
                self.sitting.given[self.participant.code, page.token] = list(accepted.values())
                await answered()
                if killed.is_set() and not was_killed:
                    was_killed = True
                    if self.participant.number % 2:
                        self.sitting.reloads += 1
                        await self._reload(tab)
            await tab.wait_for_selector(".moment .code")
        finally:
            await context.close()

    async def _begin(self, tab: Any) -> None:
        """Start, and match a card where the screen is not measured yet."""
        await self._shown(tab)
        await tab.wait_for_timeout(100)
        await tab.tap(".moment button.primary")
        await tab.wait_for_selector("form.page, .card-ground, .moment:not(:has(.code-block))")
        if await tab.query_selector(".card-handle"):
            for _ in range(3):
                await tab.keyboard.press("PageUp")
            await tab.tap(".card-page button.primary")

    async def _shown(self, tab: Any) -> None:
        """Wait for the first screen; where parts of the page were lost with the server, load it anew as people do."""
        while True:
            try:
                await tab.wait_for_selector(".moment .code", timeout=FIRST_MS)
            except Exception as error:
                if "Timeout" not in str(error):
                    raise
                await self._reach(tab.reload)
            else:
                return

    async def _moments(self, tab: Any, token: str) -> None:
        """Wait for a page, leaving rests and other moments before it."""
        page = f'form.page[data-token="{token}"]'
        while True:
            await tab.wait_for_selector(f"{page}, .moment:not(:has(.code)) button.primary")
            if await tab.query_selector(page):
                return
            await tab.wait_for_timeout(50)
            if moment := await tab.query_selector(".moment:not(:has(.code)) button.primary"):
                await moment.tap()

    async def _reload(self, tab: Any) -> None:
        """Load the page anew, as one does when nothing moves."""
        await self._reach(tab.reload)
        if next_page(self.study, self.participant, self.given) is not None:
            await self._begin(tab)

    async def _reach(self, attempt: Callable[[], Any]) -> None:
        """Try until the server is there."""
        while True:
            try:
                await attempt()
            except Exception as error:
                if not any(sign in str(error) for sign in AWAY):
                    raise
                await asyncio.sleep(0.5)
            else:
                return
