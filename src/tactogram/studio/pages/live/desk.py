"""The one sensor that a studio listens to at a time: traces, what a classifier makes of it, a session by a plan.

What runs is `workflows.capture.live` and `tactogram.workflows.capture.session`, in a thread of their own: no tab has
to stay open. What
was begun last is kept in a file, so that a session goes on after a crash.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from queue import SimpleQueue
from time import monotonic
from typing import Any, Literal

from tactogram.capture import Block, Source, SourceEnded, open_source
from tactogram.capture.live.recognition import WindowClassification
from tactogram.capture.session.feed import Feed
from tactogram.capture.session.plan import SessionPlan
from tactogram.capture.stream.monitor import TappedSource
from tactogram.errors import ParameterError, TactogramError
from tactogram.signal.io.atomic import write_text
from tactogram.studio.pages.live.console import PageConsole, PageMetronome
from tactogram.studio.pages.live.traces import Traces

State = Literal["idle", "opening", "watching", "recording"]
LEVELS_S = 0.08
"""How often the level meter is worked out, s."""
QUIET_S = 2.0
"""After so long without a block the page says that nothing comes."""
STOP_S = 6.0


@dataclass(frozen=True)
class LiveRequest:
    """Request to listen to a source.

    Parameters
    ----------
    source : str
        An address.
    run : str
        Folder of a classifier's run; empty for none.
    plan, data, session : str
        Of a recording session: plan by name or file, store, name; empty to look only.
    changes : mapping
        Values of the plan that differ.
    """

    source: str
    run: str = ""
    plan: str = ""
    data: str = ""
    session: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def session_name(self) -> str:
        """What the session is called: as said, else as `tactogram.workflows.capture.session.capture` calls it."""
        if self.session or not self.plan:
            return self.session
        subject = str(self.changes.get("subject", ""))
        values = SessionPlan.load(self.plan, changes=self.changes)
        return values.session or "-".join(
            part for part in (Path(self.plan).stem, subject or values.subject) if part
        )


class _SharedSource:
    """A source whose blocks were read by somebody else, for a `Feed` of one's own."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self.blocks: SimpleQueue[Block] = SimpleQueue()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def read(self, timeout_s: float = 0.0) -> Block | None:
        return None if self.blocks.empty() else self.blocks.get()


class LiveRunner:
    """Runs one order at a time.

    Parameters
    ----------
    folder : Path
        For ``live.json``, what was begun last.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / "live.json"
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self.state: State = "idle"
        self.number = 0
        """Of what runs, or ran last; every start counts."""
        self.order: LiveRequest | None = None
        self.console, self.metronome = PageConsole(), PageMetronome()
        self.traces = Traces()
        self.result: dict[str, Any] | None = None
        self.error: str | None = None
        self.holder: str | None = None
        """The tab that may answer; others look on."""
        self._clear()

    def _clear(self) -> None:
        self._feed: Feed | None = None
        self._handed: _SharedSource | None = None
        self._facts: dict[str, Any] = {}
        self._guess: dict[str, Any] | None = None
        self._looked = 0.0
        self._came = monotonic()

    def last_order(self) -> LiveRequest | None:
        """Return what was begun last, also before a restart; None if nothing was, or it cannot be read."""
        try:
            return LiveRequest(**json.loads(self._file.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return None

    def start(self, order: LiveRequest) -> None:
        """Begin, in a thread.

        Raises
        ------
        ParameterError
            If something runs, or the plan is none.
        TactogramError
            If the address is none.
        """
        open_source(order.source)  # refuses what is no address before anything begins
        if order.plan:
            SessionPlan.load(order.plan, changes=order.changes)
            if not order.data:
                raise ParameterError("a session needs a store to record into: give it a folder's name")
        with self._lock:
            if self.running:
                raise ParameterError("something else is being listened to: stop it first")
            self._file.parent.mkdir(parents=True, exist_ok=True)
            write_text(self._file, json.dumps(asdict(order), ensure_ascii=False, indent=1))
            self._stop.clear()
            self.number += 1
            self.order, self.result, self.error, self.state = order, None, None, "opening"
            self.console, self.metronome, self.traces = PageConsole(), PageMetronome(), Traces()
            self._clear()
            self._thread = threading.Thread(target=self._run, name="live", daemon=True)
            self._thread.start()

    @property
    def running(self) -> bool:
        """Whether something is being listened to."""
        return self._thread is not None and self._thread.is_alive()

    def stop(self) -> None:
        """End what runs, and wait until the device is let go; a take that is asked about is not kept."""
        self._stop.set()
        self.console.end()
        thread = self._thread
        if thread is not None:
            thread.join(STOP_S)

    def _run(self) -> None:
        order = self.order
        if order is None:
            return
        try:
            self.result = self._work(order)()
        except (TactogramError, OSError) as error:
            self.error = str(error)
        except Exception as error:
            self.error = f"Something unexpected ended it: {type(error).__name__}: {error}"
        finally:
            self.state = "idle"

    def _work(self, order: LiveRequest) -> Callable[[], dict[str, Any]]:
        if order.plan:
            from tactogram.workflows.capture.session import capture

            return lambda: capture(
                order.plan,
                order.source,
                order.data,
                session=order.session_name,
                changes=order.changes,
                recognise=order.run or None,
                console=self.console,
                metronome=self.metronome,
                heard=self._hear,
            )
        if order.run:
            from tactogram.workflows.capture.live import live

            return lambda: live(order.run, order.source, show=self._guessed, heard=self._hear)
        return lambda: self._watch(order.source)

    def _watch(self, address: str) -> dict[str, Any]:
        why = "stopped"
        with TappedSource(open_source(address), self._hear) as source:
            try:
                while True:
                    source.read(0.1)
            except KeyboardInterrupt:
                pass
            except SourceEnded:
                why = "the source ended"
            facts: dict[str, Any] = source.facts()
        return {"source": facts, "stopped": why, "simulated": bool(facts.get("simulated"))}

    def _hear(self, source: Source, block: Block | None) -> None:
        if self._stop.is_set() and not (self.order and self.order.plan):
            raise KeyboardInterrupt
        if self._stop.is_set() and self.console.question is None:
            raise KeyboardInterrupt  # in the middle of a take; where a question stands, it is answered with q
        if self._feed is None:
            self._handed = _SharedSource(source)
            self._feed = Feed(self._handed, silence_s=float("inf"))
            self.state = "recording" if self.order and self.order.plan else "watching"
        if block is not None and self._handed is not None:
            self._came = monotonic()
            self._handed.blocks.put(block)
            self._feed.poll(0.0)
            self.traces.add(block.samples, self._feed.rate)
        if monotonic() - self._looked > LEVELS_S:
            self._looked = monotonic()
            levels = self._feed.levels()
            self._facts = {
                "axes": list(source.axes),
                "unit": source.unit,
                "simulated": bool(source.facts().get("simulated")) if not self._facts else self.simulated,
                "levels": {**asdict(levels), "rms": float(levels.rms)},
                "nominal_rate": source.rate,
                "samples": self._feed.next_index,
            }

    @property
    def simulated(self) -> bool:
        """Whether what is heard is simulated."""
        return bool(self._facts.get("simulated"))

    def _guessed(self, guess: WindowClassification) -> None:
        self._guess = guess.facts()

    def now(self, after: int = 0, number: int = 0) -> dict[str, Any]:
        """Return what pages draw, as JSON values.

        Parameters
        ----------
        after : int
            Bin from which on the page has not drawn yet; see `Traces.since`.
        number : int
            What the page drew last: where something else began since, it gets all bins.
        """
        status = self.console.status
        question = self.console.question
        shown = None
        if status is not None and self.state == "recording":
            shown = {"place": status.place, "phase": status.phase, "text": status.text, "share": status.share}
        return {
            "number": self.number,
            "state": self.state,
            **self._facts,
            "silent_s": round(monotonic() - self._came, 1) if self.running else 0.0,
            "traces": self.traces.since(after if number == self.number else 0),
            "guess": self._guess,
            "status": shown,
            "question": None if question is None else question.facts(),
            "beat": self.metronome.facts(),
        }
