"""Stimuli of a session as bytes for a page, prepared in a thread so that the first sound does not wait."""

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
from tactogram.rendering import Display
from tactogram.signal import Signal
from tactogram_study.stimuli import Stimulus
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, PresentedStimulus
from tactogram_study.workflows.stimuli import SlotPlayback, StudyStimuli, check_browser
from tactogram_study.workflows.streams import FingerStream

T = TypeVar("T")

MOST_QUEUED = 200
"""Stimuli that are prepared before a page requests them."""
MOST_PICTURE_BYTES = 256 * 2**20
"""Cached pictures; the least recently shown go first."""
SILENCE_S = 1.0
"""Length of a silent slot where no other slot of its page sets one."""
PATIENCE_S = 10.0
"""Wait for the current stimulus when a session is closed."""

log = logging.getLogger("tactogram_studio")


class PreparedStimuli(StudyStimuli):
    """Stimuli of one study, for any thread; concurrent requests for one stimulus make it once."""

    def __init__(self, study: Study, folder: Path, *, within: Sequence[Path]) -> None:
        super().__init__(study, folder, within=within)
        self.failures: dict[str, str] = {}
        """Why a stimulus could not be made, by name."""
        self._pictures: OrderedDict[str, bytes] = OrderedDict()
        self._guard = threading.Lock()
        self._locks: defaultdict[object, threading.Lock] = defaultdict(threading.Lock)
        self._wakeup = threading.Condition()
        self._next_pages: deque[PresentedStimulus] = deque(maxlen=MOST_QUEUED)
        self._queue = deque(PresentedStimulus("", stimulus) for stimulus in study.all_stimuli[:MOST_QUEUED])
        self._stopped = False
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start preparing stimuli in a thread, unless it runs."""
        with self._guard:
            if self._thread is None:
                self._thread = threading.Thread(target=self._prepare_all, name="stimuli", daemon=True)
                self._thread.start()

    def stop(self) -> None:
        """Stop preparing and wait for the current stimulus: a process that exits amid native code is aborted."""
        with self._wakeup:
            self._stopped = True
            self._wakeup.notify()
        if self._thread is not None:
            self._thread.join(PATIENCE_S)

    @property
    def displays(self) -> tuple[Display, ...]:
        """Displays that play any stimulus."""
        played = [stimulus for stimulus in self.study.all_stimuli if stimulus.is_played]
        named = {stimulus.display or self.study.display: stimulus for stimulus in played}
        return tuple(map(self.display, named.values()))

    def drive(self, page: Page, slot: str) -> tuple[Signal, SlotPlayback]:
        """Return a slot's drive and how it was rendered.

        Silence has the length, rate and channels of the page's other slots. An error names the stimulus: it is not for
        participants.
        """
        if self.study.played_by == "browser":
            check_browser(self.display(page.slot(slot).stimulus))
        played = self._played(page.slot(slot))
        return (played.drive.signal if played.drive is not None else self._silence(page)), played

    def stream(self, page: Page, slot: str, *, landed_s: float) -> tuple[FingerStream, SlotPlayback]:
        """Return a slot's stimulus to be streamed, and how it was made; silence is any other slot's, held at rest.

        An error names the stimulus: it is not for participants.
        """
        played = self._played(page.slot(slot))
        streams = (self._played(presented).stream for presented in (page.slot(slot), *page.presented))
        shown = next((stream for stream in streams if stream is not None), None)
        if shown is None:
            raise ParameterError(f"page {page.token} has no stimulus to stream")
        return FingerStream(shown, silent=played.stream is None, landed_s=landed_s), played

    def prepare(self, page: Page) -> None:
        """Prepare the stimuli of a page before all others."""
        with self._wakeup:
            self._next_pages.extend(
                presented for presented in page.presented if presented.stimulus is not None
            )
            self._wakeup.notify()

    def _played(self, presented: PresentedStimulus) -> SlotPlayback:
        name = presented.stimulus.name if presented.stimulus is not None else ""
        return self._made_once(name, ("played", name, presented.gain_db), lambda: self.played(presented))

    def picture(self, stimulus: Stimulus) -> bytes:
        """Return the picture of a stimulus as PNG without metadata; `ParameterError` if it has none."""

        def made() -> bytes:
            with self._guard:
                if stimulus.name in self._pictures:
                    self._pictures.move_to_end(stimulus.name)
                    return self._pictures[stimulus.name]
            image = self.image(stimulus)
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

        return self._made_once(stimulus.name, ("picture", stimulus.name), made)

    def _made_once(self, name: str, key: object, make: Callable[[], T]) -> T:
        """Return ``make()``, one thread at a time for each key; record an error for the experimenter."""
        with self._guard:
            lock = self._locks[key]
        with lock:
            try:
                content = make()
            except TactogramError as error:
                self.failures[name] = str(error)
                raise
        self.failures.pop(name, None)
        return content

    def _silence(self, page: Page) -> Signal:
        for presented in page.presented:
            if presented.stimulus is not None and presented.stimulus.is_played:
                drive = self._played(presented).drive
                if drive is not None:
                    return drive.signal.with_samples(np.zeros_like(drive.signal.samples))
        display = self.display(None)
        samples = np.zeros((len(display.channels), round(SILENCE_S * display.rate)), np.float32)
        return Signal(samples, display.rate, display.unit, display.channels)

    def _prepare_all(self) -> None:
        while (presented := self._next()) is not None:
            stimulus = presented.stimulus
            if stimulus is None:
                continue
            try:
                if stimulus.is_played:
                    self._played(presented)
                if stimulus.is_seen:
                    self.picture(stimulus)
            except TactogramError as error:
                log.warning("%s", error)
            except Exception:  # a bug must not end the thread: the other stimuli can be made
                log.exception("a stimulus could not be made")
                self.failures[stimulus.name] = f"stimulus {stimulus.name}: program error; see the log"

    def _next(self) -> PresentedStimulus | None:
        """Wait for the next stimulus to prepare and return it; None once stopped."""
        with self._wakeup:
            while not self._stopped:
                if self._next_pages:
                    return self._next_pages.popleft()
                if self._queue:
                    return self._queue.popleft()
                self._wakeup.wait()
        return None


def wav_bytes(signal: Signal) -> bytes:
    """Return a drive as WAV: 32-bit floats, channels interleaved."""
    import soundfile

    file = io.BytesIO()
    soundfile.write(file, signal.samples.T, round(signal.rate), format="WAV", subtype="FLOAT")
    return file.getvalue()
