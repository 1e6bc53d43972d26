"""A recording session: what the plan asks for, take by take, each in the store before the next one begins.

The store is the session's memory. A take is accepted when it stands there, on the disk; what the session's diary says
besides (order, redone and skipped takes, verdicts) is of use, but nothing that was accepted depends on it. So a session
may end at any instant, a pulled plug included, and goes on where it stopped.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from tactogram.capture.session.console import CaptureStatus, Console
from tactogram.capture.session.feed import Feed
from tactogram.capture.session.journal import Journal
from tactogram.capture.session.metronome import Metronome, SilentMetronome, interval_s
from tactogram.capture.session.plan import PlannedTake, SessionPlan
from tactogram.capture.session.take import RECEIVED, Take, bridged, recording_of
from tactogram.capture.session.take_checks import TakeAssessment, checked
from tactogram.capture.source import Source, SourceEnded, SourceLost
from tactogram.datasets import Store
from tactogram.datasets.store.appending import append_recording, recovered
from tactogram.errors import DataError, ParameterError, TactogramError, one_line
from tactogram.signal import Signal

MOST_REDONE = 3
"""Takes of one trial that are made without anybody there, before it is skipped."""
SLOWEST = 1.5
"""A take that has not come together after so many times its length is stopped, and is too short."""

BEGIN = {"b": "begin", "s": "skip", "q": "stop"}
DECIDE = {"a": "accept", "r": "redo", "s": "skip", "q": "stop"}

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]*")

Recognise = Callable[[Signal], Mapping[str, float]]
"""What a trained classifier makes of a signal: probabilities by material. Handed in; nothing here knows networks."""


def session_folder(store: Path, session: str) -> Path:
    """Return where the diary and the raw logs of a session are: ``STORE.sessions/SESSION``, beside the store.

    Raises
    ------
    ParameterError
        If ``session`` cannot be the name of a folder.
    """
    if not _NAME.fullmatch(session):
        raise ParameterError(f"a session's name must be letters, digits and _.+-, got {session!r}")
    return store.with_name(f"{store.name}.sessions") / session


@dataclass(frozen=True)
class SessionProgress:
    """Progress of a session.

    Parameters
    ----------
    trials : tuple of Trial
        All, in their order.
    accepted, skipped : frozenset of int
        Their numbers.
    """

    trials: tuple[PlannedTake, ...]
    accepted: frozenset[int] = frozenset()
    skipped: frozenset[int] = frozenset()

    @property
    def left(self) -> tuple[PlannedTake, ...]:
        """What is still to be made."""
        return tuple(t for t in self.trials if t.number not in self.accepted | self.skipped)


def progress_of(plan: SessionPlan, session: str, journal: Journal, store: Store | None) -> SessionProgress:
    """Return how far a session is, out of its diary and the store.

    A session of which nothing was kept may be begun anew with another plan.

    Raises
    ------
    DataError
        If the session was begun with another plan.
    """
    trials = plan.trials()
    taken = [] if store is None else [info for info in store.index if info.session == session]
    if begun := journal.of("begun"):
        if begun[-1]["plan"] != plan.sha256:
            if not taken and not journal.of("skipped"):
                return SessionProgress(trials, frozenset(), frozenset())
            raise DataError(
                f"{journal.folder}: session {session!r} was begun with another plan; go on with that one "
                f"(it stands in {journal.path}), or give --session another name"
            )
        # As it was drawn then: another numpy may draw another order from the same seed.
        trials = tuple(PlannedTake(**entry) for entry in begun[-1]["order"])
    accepted = {int(info.labels["trial"]) for info in taken if info.labels.get("plan") == plan.sha256[:16]}
    skipped = {int(entry["trial"]) for entry in journal.of("skipped")} - accepted
    return SessionProgress(trials, frozenset(accepted), frozenset(skipped))


class RecordingSession:
    """Runs a plan.

    Parameters
    ----------
    store : Path
        Where takes go; made with the first one.
    name : str
        What the session is called.
    source : Source
        Open.
    console : Console
        Where it is shown and asked.
    journal : Journal
        Open.
    recognise : callable, optional
        See `Recognise`; each take is shown with what it sounds like.
    on_trial : callable, optional
        Called with each trial before it is asked for: a simulated device then plays what is to be stroked.
    log : str
        Name of the raw log that the source writes, in the session's folder.
    clock : callable
        As ``time.monotonic``.
    """

    def __init__(
        self,
        plan: SessionPlan,
        store: Path,
        name: str,
        source: Source,
        console: Console,
        journal: Journal,
        *,
        metronome: Metronome | None = None,
        recognise: Recognise | None = None,
        on_trial: Callable[[PlannedTake], None] | None = None,
        log: str = "",
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self.plan, self.store_path, self.name = plan, store, name
        self._source, self._console, self._journal = source, console, journal
        self._metronome: Metronome = metronome or SilentMetronome()
        self._recognise, self._on_trial, self._log, self._clock = recognise, on_trial, log, clock
        self._feed = Feed(source, reference_rate=plan.rate, full_scale=plan.limits.full_scale, clock=clock)
        self._place = ""
        self._gone: TactogramError | None = None
        opened, removed = recovered(store)
        if removed:
            console.say(f"{store}: removed what an interrupted session left ({', '.join(removed)})")
        self.progress = progress_of(plan, name, journal, opened)
        if opened is not None and self._feed.reference_rate is None:
            self._feed.reference_rate = self._earlier_rate(opened)
        self.counts = {"accepted": 0, "redone": 0, "skipped": 0}

    def run(self) -> dict[str, Any]:
        """Make what is left of the plan, or until somebody stops it or the source ends.

        Returns
        -------
        dict
            ``accepted``, ``redone``, ``skipped`` (in this run), ``left``, ``stopped`` (why it ended early, or None).

        Raises
        ------
        SourceLost
            If the source went away. What was accepted is in the store.
        """
        begun = self._journal.of("begun")
        if not begun or begun[-1]["plan"] != self.plan.sha256:
            order = [vars(trial) for trial in self.progress.trials]
            values = self.plan.model_dump(mode="json")
            self._journal.write("begun", {"plan": self.plan.sha256, "order": order, "values": values})
        done = len(self.progress.accepted)
        if done or self.progress.skipped:
            self._console.say(
                f"going on with session {self.name}: {done} of {len(self.progress.trials)} takes are in the store, "
                f"{len(self.progress.skipped)} skipped"
            )
        self._journal.write("opened", {"source": self._source.name, "log": self._log})
        stopped = None
        try:
            for trial in self.progress.left:
                if not self._trial(trial):
                    stopped = "stopped by the experimenter"
                    break
        except KeyboardInterrupt:
            stopped = "interrupted"
        except SourceEnded:
            stopped = f"{self._source.name} ended"
        except SourceLost as error:
            self._note("lost", {"error": str(error)})
            raise SourceLost(
                f"{error}; {self.counts['accepted']} takes of this run are in {self.store_path}: connect it again and "
                "run the same command to go on"
            ) from error
        finally:
            self._metronome.stop()
        left = len(self.progress.left) - self.counts["accepted"] - self.counts["skipped"]
        self._note("closed", {"left": left, "why": stopped})
        return {**self.counts, "left": left, "stopped": stopped}

    def _earlier_rate(self, store: Store) -> float | None:
        """Return the rate of what this session put into the store before, None if it did not."""
        for info in store.index:
            if info.session == self.name:
                return store.rate(info.id, next(s for s in store.streams_of(info.id) if s != RECEIVED))
        return None

    def _trial(self, trial: PlannedTake) -> bool:
        """Make one trial; False if somebody wants to stop."""
        force = f", {self.plan.force_n:g} N" if self.plan.force_n is not None else ""
        self._place = f"take {trial.number} of {len(self.progress.trials)}: {trial}{force}"
        if self._on_trial is not None:
            self._on_trial(trial)
        attempt = 1 + sum(entry["trial"] == trial.number for entry in self._journal.of("take"))
        automatic = 1
        begun = self._ask(self._place, BEGIN, default="b")
        while begun == "b":
            take = self._record(trial)
            verdict = self._judge(take)
            facts = {"trial": trial.number, "attempt": attempt, "first_index": take.first_index}
            facts |= {"samples": len(take), "lost": take.lost, "rate": take.rate, "verdict": verdict.facts()}
            default = "a" if verdict.good else "r" if automatic < MOST_REDONE else "s"
            found = f"{self._place}: {verdict}{self._heard(take)}"
            decision = self._decide(trial, take, verdict, question=found, default=default)
            self._console.say(f"{found} -> {DECIDE[decision]}")
            self._note("take", facts | {"decision": DECIDE[decision], "log": self._log})
            if decision == "a":
                self.counts["accepted"] += 1
                # All takes of a session are called by one rate: a crystal changes less than its measurement does.
                self._feed.reference_rate = self._feed.reference_rate or take.rate
                return True
            if decision == "r":
                self.counts["redone"] += 1
                attempt, automatic = attempt + 1, automatic + 1
                continue
            begun = decision
        if begun == "s":
            self._journal.write("skipped", {"trial": trial.number})
            self.counts["skipped"] += 1
            return True
        return False

    def _record(self, trial: PlannedTake) -> Take:
        """Count down, record, and return what came."""
        plan, feed = self.plan, self._feed
        if self._gone is not None:
            raise self._gone
        feed.release()
        end = self._clock() + plan.countdown_s
        while (remaining := end - self._clock()) > 0:
            feed.poll(min(0.1, remaining))
            self._show("countdown", f"{remaining:.1f} s", 1 - remaining / max(plan.countdown_s, 1e-9))
        # Without a rate nobody knows how many samples a take has.
        while feed.rate is None:
            feed.poll()
            self._show("waiting", "for the source's rate", 0.0)
        start, begun = feed.mark(), self._clock()
        if plan.metronome:
            beat = interval_s(plan.stroke_mm, trial.speed_mm_s)
            self._metronome.start(beat, plan.seconds, back_and_forth=plan.back_and_forth)
        try:
            while (
                feed.next_index - start < self._wanted()
                and self._clock() - begun < SLOWEST * plan.seconds + 2
            ):
                feed.poll()
                share = (feed.next_index - start) / self._wanted()
                self._show("recording", f"{share * plan.seconds:.1f} of {plan.seconds:g} s", share)
        finally:
            self._metronome.stop()
        stop = min(feed.next_index, start + self._wanted())
        return feed.take(start, stop)

    def _wanted(self) -> int:
        """How many samples a take has."""
        return max(1, round(self.plan.seconds * (self._feed.rate or 1.0)))

    def _judge(self, take: Take) -> TakeAssessment:
        nominal = self._feed.reference_rate
        return checked(
            take,
            self.plan.limits,
            seconds=self.plan.seconds,
            nominal=nominal,
            full_scale=self._feed.full_scale,
        )

    def _heard(self, take: Take) -> str:
        """Return what a classifier makes of a take, as the end of a line."""
        if self._recognise is None or take.lost == len(take):
            return ""
        try:
            found = self._recognise(Signal(bridged(take.samples)[0], take.rate, take.unit, take.axes))
        except TactogramError as error:
            return f"; not recognised: {error}"
        name = max(found, key=lambda material: found[material])
        return f"; sounds like {name} ({found[name]:.2f})"

    def _decide(
        self, trial: PlannedTake, take: Take, verdict: TakeAssessment, *, question: str, default: str
    ) -> str:
        """Return what is decided about a take; ``"a"`` means that it is in the store."""
        while True:
            decision = self._ask(question, DECIDE, default=default)
            if decision != "a":
                return decision
            try:
                self._accept(trial, take, verdict)
            except (OSError, DataError) as error:
                why = one_line(error)
                self._console.say(f"NOT stored: {why}; the store is as it was, and the take still at hand")
                default = "q" if isinstance(error, OSError) else "r"
            else:
                return decision

    def _accept(self, trial: PlannedTake, take: Take, verdict: TakeAssessment) -> None:
        """Put a take into the store; it is on the disk when this returns.

        Raises
        ------
        OSError
            If the disk is full.
        DataError
            If it cannot stand there: no sample came, or the same samples are there already.
        """
        plan = self.plan
        labels = {
            "plan": plan.sha256[:16],
            "trial": str(trial.number),
            "repetition": str(trial.repetition),
            "first_index": str(take.first_index),
            "verdict": str(verdict),
            "source": self._source.name,
        }
        labels |= {key: value for key, value in (("log", self._log), ("notes", plan.notes)) if value}
        what = {
            "material": trial.material,
            "contactor": trial.contactor,
            "speed_mm_s": trial.speed_mm_s,
            "force_n": plan.force_n,
            "direction_deg": plan.direction_deg,
            "session": self.name,
            "subject": plan.subject or None,
            "labels": labels,
            "source": f"{self.name}/{trial.number:04d}",
        }
        simulated = bool(self._source.facts().get("simulated"))
        recording = recording_of(take, stream=plan.stream, what=what, simulated=simulated)
        append_recording(
            self.store_path,
            recording,
            name=self.store_path.name,
            licence=plan.licence,
            source=f"capture: {plan.title}".removesuffix(": "),
        )

    def _ask(self, question: str, keys: Mapping[str, str], *, default: str) -> str:
        """Ask, and read the source meanwhile: what nobody reads piles up in the cable."""
        self._console.show(CaptureStatus(self._place, "question", question, levels=self._feed.levels()))

        def read() -> None:
            # A source that goes away now takes nothing with it: the take that is asked about is at hand.
            if self._gone is not None:
                sleep(0.05)
                return
            try:
                self._feed.poll(0.05, patient=True)
            except TactogramError as error:
                self._gone = error
            self._show("question", question, 0.0)

        return self._console.ask(question, keys, default=default, idle=read)

    def _show(self, phase: str, text: str, share: float) -> None:
        self._console.show(CaptureStatus(self._place, phase, text, share, self._feed.levels()))

    def _note(self, event: str, facts: Mapping[str, Any]) -> None:
        """Write into the diary; where the disk is full the session goes on: the store says what matters."""
        try:
            self._journal.write(event, facts)
        except OSError as error:
            self._console.say(f"the diary could not be written: {one_line(error)}")
