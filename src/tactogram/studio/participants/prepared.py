"""Stimuli of a session as bytes for a page, made ahead in a thread so that the first sound does not wait."""

from __future__ import annotations

import io
import logging
import threading
from collections import OrderedDict, defaultdict, deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from tactogram.errors import ParameterError, TactogramError
from tactogram.rendering.displays.catalogue import open_display, shipped
from tactogram.rendering.displays.display import Display
from tactogram.signal import Signal
from tactogram.study.stimuli import Stimulus
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PresentedStimulus
from tactogram.workflows.study.stimuli import SlotPlayback, StudyStimuli

T = TypeVar("T")

AHEAD = 200
"""Stimuli that are made before anybody asks."""
MOST_PICTURE_BYTES = 256 * 2**20
"""Of pictures that are kept; the least recently shown go first."""
SILENCE_S = 1.0
"""Of a silent slot, where nothing else on its page says how long it is."""
PATIENCE_S = 10.0
"""For the stimulus that is being made when a session is closed."""
BROWSER_RATES = (8000, 96_000)
"""Rates that every browser's sound takes, Hz (Web Audio API, createBuffer); beyond them Firefox refuses."""

log = logging.getLogger("tactogram.studio")


class PreparedStimuli:
    """Those of one study. Any thread may ask; what two ask for at once is made once.

    Parameters
    ----------
    study : Study
    folder : Path
        What its files stand beside.
    within : sequence of Path
        That they must lie in.
    """

    def __init__(self, study: Study, folder: Path, *, within: Sequence[Path]) -> None:
        self.study = study
        self.troubles: dict[str, str] = {}
        self._made = StudyStimuli(study, folder, within=within)
        self._pictures: OrderedDict[str, bytes] = OrderedDict()
        self._guard = threading.Lock()
        self._locks: defaultdict[object, threading.Lock] = defaultdict(threading.Lock)
        self._wanted = threading.Condition()
        self._soon: deque[PresentedStimulus] = deque(maxlen=AHEAD)
        self._later = deque(PresentedStimulus("", stimulus) for stimulus in study.all_stimuli[:AHEAD])
        self._begun = self._ended = False
        self._thread: threading.Thread | None = None

    def check(self) -> None:
        """Refuse a study whose files lie elsewhere, or that a browser is to play and cannot.

        Raises
        ------
        TactogramError
            In one line.
        """
        self._made.check_places()
        if self.study.played_by == "browser":
            for display in self.displays:
                check_browser(display)

    def begin(self) -> None:
        """Make stimuli ahead, in a thread; once, however often it is called."""
        with self._guard:
            if self._begun:
                return
            self._begun = True
            self._thread = threading.Thread(target=self._run, name="stimuli", daemon=True)
            self._thread.start()

    def end(self) -> None:
        """Make no more ahead, and wait for what is being made: a program that ends amid native code is aborted."""
        with self._wanted:
            self._ended = True
            self._wanted.notify()
        if self._thread is not None:
            self._thread.join(PATIENCE_S)

    @property
    def displays(self) -> tuple[Display, ...]:
        """Those that anything is played on."""
        played = [stimulus for stimulus in self.study.all_stimuli if stimulus.is_played]
        named = {stimulus.display or self.study.display: stimulus for stimulus in played}
        return tuple(self._made.display(stimulus) for stimulus in named.values())

    def display(self, presented: PresentedStimulus) -> Display:
        """Return what a slot is played on; of silence the study's."""
        if presented.stimulus is None:
            return open_display(self.study.display)
        return self._made.display(presented.stimulus)

    def drive(self, page: Page, slot: str) -> tuple[Signal, SlotPlayback]:
        """Return what a slot sends to the display, and what was rendered.

        Silence is as long as the other slots of the page, and has their rate and channels.

        Raises
        ------
        TactogramError
            If it cannot be made; the message names the stimulus, and is not for participants.
        """
        if self.study.played_by == "browser":
            check_browser(self.display(page.slot(slot)))
        played = self._once(page.slot(slot))
        return (played.drive.signal if played.drive is not None else self._silence(page)), played

    def ahead(self, page: Page) -> None:
        """Let the drives of a page be made next, before others that nobody waits for."""
        with self._wanted:
            self._soon.extend(presented for presented in page.presented if presented.stimulus is not None)
            self._wanted.notify()

    def picture(self, page: Page, slot: str) -> bytes:
        """Return the picture of a slot as PNG, without anything that says where it comes from.

        Raises
        ------
        ParameterError
            If the slot has none.
        """
        stimulus = page.slot(slot).stimulus
        if stimulus is None or not stimulus.is_seen:
            raise ParameterError(f"page {page.token} shows no picture in slot {slot!r}")
        return self._picture(stimulus)

    def _once(self, presented: PresentedStimulus) -> SlotPlayback:
        name = presented.stimulus.name if presented.stimulus is not None else ""
        return self._noted(name, ("played", name, presented.gain_db), lambda: self._made.played(presented))

    def _picture(self, stimulus: Stimulus) -> bytes:
        def made() -> bytes:
            with self._guard:
                if stimulus.name in self._pictures:
                    self._pictures.move_to_end(stimulus.name)
                    return self._pictures[stimulus.name]
            image = self._made.image(stimulus)
            if image is None:
                raise ParameterError(f"stimulus {stimulus.name} has no picture")
            from PIL import Image as Pillow

            file = io.BytesIO()
            Pillow.fromarray(image.pixels).save(file, format="PNG")
            with self._guard:
                self._pictures[stimulus.name] = file.getvalue()
                while sum(map(len, self._pictures.values())) > MOST_PICTURE_BYTES and len(self._pictures) > 1:
                    self._pictures.popitem(last=False)
            return file.getvalue()

        return self._noted(stimulus.name, ("picture", stimulus.name), made)

    def _noted(self, name: str, key: object, make: Callable[[], T]) -> T:
        """Make something alone, and keep what went wrong for the experimenter."""
        with self._guard:
            lock = self._locks[key]
        with lock:
            try:
                made = make()
            except TactogramError as error:
                self.troubles[name] = str(error)
                raise
        self.troubles.pop(name, None)
        return made

    def _silence(self, page: Page) -> Signal:
        for presented in page.presented:
            if presented.stimulus is not None and presented.stimulus.is_played:
                drive = self._once(presented).drive
                if drive is not None:
                    return drive.signal.with_samples(np.zeros_like(drive.signal.samples))
        display = open_display(self.study.display)
        samples = np.zeros((len(display.channels), round(SILENCE_S * display.rate)), np.float32)
        return Signal(samples, display.rate, display.unit, display.channels)

    def _run(self) -> None:
        while (presented := self._next()) is not None:
            stimulus = presented.stimulus
            if stimulus is None:
                continue
            try:
                if stimulus.is_played:
                    self._once(presented)
                if stimulus.is_seen:
                    self._picture(stimulus)
            except TactogramError as error:
                log.warning("%s", error)
            except Exception:  # a program's error must not end the thread: the others can be made
                log.exception("a stimulus could not be made")
                self.troubles[stimulus.name] = (
                    f"stimulus {stimulus.name}: an error in the program; see the log"
                )

    def _next(self) -> PresentedStimulus | None:
        """Return what to make next, waiting for it; None at the end."""
        with self._wanted:
            while not self._ended:
                if self._soon:
                    return self._soon.popleft()
                if self._later:
                    return self._later.popleft()
                self._wanted.wait()
        return None


def wav_bytes(signal: Signal) -> bytes:
    """Return a drive as WAV: 32-bit floats, channels interleaved."""
    import soundfile

    file = io.BytesIO()
    soundfile.write(file, signal.samples.T, round(signal.rate), format="WAV", subtype="FLOAT")
    return file.getvalue()


def check_browser(display: Display) -> None:
    """Refuse a display that no browser can stand in for.

    Raises
    ------
    ParameterError
        If its drive is not in parts of full scale, or at a rate that browsers do not play.
    """
    if not _by_browser(display):
        low, high = BROWSER_RATES
        usable = ", ".join(known for known in shipped() if _by_browser(open_display(known)))
        raise ParameterError(
            f"a browser plays parts of full scale at {low} to {high} Hz, {display.name} takes {display.unit} at "
            f"{display.rate:g} Hz: give a display such as {usable}, or played_by = 'server'"
        )


def _by_browser(display: Display) -> bool:
    low, high = BROWSER_RATES
    return display.unit == "1" and low <= display.rate <= high and display.rate % 1 == 0
