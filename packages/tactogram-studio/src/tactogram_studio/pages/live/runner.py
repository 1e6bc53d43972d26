"""Live runner: the one sensor that a studio listens to at a time, for traces, a classifier or a recording session.

It runs `tactogram_capture.workflows.live` or `tactogram_capture.workflows.session` in a thread, so that no tab has to
stay open. The last request is stored in a file: a session continues after a crash.
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

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal.io import write_text
from tactogram.text_files import read_json
from tactogram_capture import Block, Source, SourceEnded, open_source
from tactogram_capture.live.recognition import WindowClassification
from tactogram_capture.session.feed import Feed
from tactogram_capture.session.plan import SessionPlan
from tactogram_capture.source import TappedSource
from tactogram_studio.pages.live.console import PageConsole, PageMetronome
from tactogram_studio.pages.live.traces import Traces

State = Literal["idle", "opening", "watching", "recording"]
LEVELS_S = 0.08
"""Interval between updates of the level meter, s."""
STOP_S = 6.0


@dataclass(frozen=True)
class LiveRequest:
    """Request to listen to a ``source`` (an address).

    ``run`` is the folder of a classifier run, or empty. A recording session also has a ``plan`` (name or file),
    ``data`` (its store), an optional name and ``changes`` of the plan's values.
    """

    source: str
    run: str = ""
    plan: str = ""
    data: str = ""
    session: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def session_name(self) -> str:
        """Name of the session; by default as `tactogram_capture.workflows.session.capture` chooses it."""
        if self.session or not self.plan:
            return self.session
        subject = str(self.changes.get("subject", ""))
        values = SessionPlan.load(self.plan, changes=self.changes)
        return values.session or "-".join(
            part for part in (Path(self.plan).stem, subject or values.subject) if part
        )


class _SharedSource:
    """A source whose blocks another reader passes on, for a second `Feed`."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self.blocks: SimpleQueue[Block] = SimpleQueue()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._source, name)

    def read(self, timeout_s: float = 0.0) -> Block | None:
        return None if self.blocks.empty() else self.blocks.get()


class LiveRunner:
    """Runs one request at a time, and stores it as ``live.json`` in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "live.json"
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self.state: State = "idle"
        self.number = 0
        """Number of the current or last request."""
        self.request: LiveRequest | None = None
        self.console, self.metronome = PageConsole(), PageMetronome()
        self.traces = Traces()
        self.result: dict[str, Any] | None = None
        self.error: str | None = None
        self.holder: str | None = None
        """Tab that may answer questions; others only watch."""
        self._clear()

    def _clear(self) -> None:
        self._feed: Feed | None = None
        self._shared: _SharedSource | None = None
        self._facts: dict[str, Any] = {}
        self._guess: dict[str, Any] | None = None
        self._levels_at = 0.0
        self._block_at = monotonic()

    def last_request(self) -> LiveRequest | None:
        """Return the last request, also after a restart; None if there is none, or it cannot be read."""
        try:
            return LiveRequest(**read_json(self._file))
        except (DataError, TypeError):
            return None

    def start(self, request: LiveRequest) -> None:
        """Start a request in a thread.

        Raises `ParameterError` if another request is running, or source, plan or store are invalid.
        """
        open_source(request.source)  # checks the address
        if request.plan:
            SessionPlan.load(request.plan, changes=request.changes)
            if not request.data:
                raise ParameterError("a session needs a store; enter a folder's name")
        with self._lock:
            if self.running:
                raise ParameterError("the sensor is in use; stop it first")
            self._file.parent.mkdir(parents=True, exist_ok=True)
            write_text(self._file, json.dumps(asdict(request), ensure_ascii=False, indent=1))
            self._stop.clear()
            self.number += 1
            self.request, self.result, self.error, self.state = request, None, None, "opening"
            self.console, self.metronome, self.traces = PageConsole(), PageMetronome(), Traces()
            self._clear()
            self._thread = threading.Thread(target=self._run, name="live", daemon=True)
            self._thread.start()

    @property
    def running(self) -> bool:
        """Whether a request is running."""
        return self._thread is not None and self._thread.is_alive()

    def stop(self) -> None:
        """Stop the request and wait until the device is free; a take without an answer is discarded."""
        self._stop.set()
        self.console.end()
        thread = self._thread
        if thread is not None:
            thread.join(STOP_S)

    def _run(self) -> None:
        request = self.request
        if request is None:
            return
        try:
            self.result = self._work(request)()
        except (TactogramError, OSError) as error:
            self.error = str(error)
        except Exception as error:
            self.error = f"Unexpected error: {type(error).__name__}: {error}"
        finally:
            self.state = "idle"

    def _work(self, request: LiveRequest) -> Callable[[], dict[str, Any]]:
        if request.plan:
            from tactogram_capture.workflows.session import capture

            return lambda: capture(
                request.plan,
                source=request.source,
                data=request.data,
                session=request.session_name,
                changes=request.changes,
                recognise=request.run or None,
                console=self.console,
                metronome=self.metronome,
                heard=self._hear,
            )
        if request.run:
            from tactogram_capture.workflows.live import live

            return lambda: live(
                request.run, source=request.source, on_window=self._show_guess, heard=self._hear
            )
        return lambda: self._watch(request.source)

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
        session = self.request is not None and bool(self.request.plan)
        # An open question of a session is answered with q instead.
        if self._stop.is_set() and not (session and self.console.question is not None):
            raise KeyboardInterrupt
        if self._feed is None:
            self._shared = _SharedSource(source)
            self._feed = Feed(self._shared, silence_s=float("inf"))
            self.state = "recording" if session else "watching"
        if block is not None and self._shared is not None:
            self._block_at = monotonic()
            self._shared.blocks.put(block)
            self._feed.poll(0.0)
            self.traces.add(block.samples, self._feed.rate)
        if monotonic() - self._levels_at > LEVELS_S:
            self._levels_at = monotonic()
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
        """Whether the source is simulated."""
        return bool(self._facts.get("simulated"))

    def _show_guess(self, guess: WindowClassification) -> None:
        self._guess = guess.facts()

    def now(self, after: int = 0, number: int = 0) -> dict[str, Any]:
        """Return what pages draw, as JSON values.

        ``after`` is the first bin that the page needs (see `Traces.since`), ``number`` the request that it drew last:
        after another request it gets all bins.
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
            "silent_s": round(monotonic() - self._block_at, 1) if self.running else 0.0,
            "traces": self.traces.since(after if number == self.number else 0),
            "guess": self._guess,
            "status": shown,
            "question": None if question is None else question.facts(),
            "beat": self.metronome.facts(),
        }
