"""Recording session: the takes of a plan, each in the store before the next one begins.

The store is the session's memory. A take is accepted once it is in the store, on the disk; the session's journal adds
order, redone and skipped takes, and verdicts, but no accepted take depends on it. A session can therefore
be interrupted at any moment, even by a pulled plug, and continues where it stopped.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from tactogram.datasets import Store, append_recording, recover_store
from tactogram.errors import DataError, ParameterError, TactogramError, one_line
from tactogram.signal import Signal
from tactogram_capture.session.console import CaptureStatus, Console
from tactogram_capture.session.feed import Feed
from tactogram_capture.session.journal import Journal
from tactogram_capture.session.metronome import Metronome, interval_s
from tactogram_capture.session.plan import PlannedTake, SessionPlan
from tactogram_capture.session.take import RECEIVED, Take, TakeAssessment, check_take, recording_of
from tactogram_capture.source import Source, SourceEnded, SourceLost
from tactogram_capture.stream.gaps import bridged

MOST_REDONE = 3
"""Attempts at one trial in an unattended session, before it is skipped."""
SLOWEST = 1.5
"""A take is stopped after this multiple of its length, and is then too short."""

BEGIN = {"b": "begin", "s": "skip", "q": "stop"}
DECIDE = {"a": "accept", "r": "redo", "s": "skip", "q": "stop"}

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]*")

Recognise = Callable[[Signal], Mapping[str, float]]
"""Function from a signal to the probabilities of materials. Passed in, so that this package needs no networks."""


def session_folder(store: Path, session: str) -> Path:
    """Return the folder of a session's journal and raw logs: ``STORE.sessions/SESSION``, next to the store.

    Raises `ParameterError` if ``session`` cannot be the name of a folder.
    """
    if not _NAME.fullmatch(session):
        raise ParameterError(f"a session's name must be letters, digits and _.+-, got {session!r}")
    return store.with_name(f"{store.name}.sessions") / session


@dataclass(frozen=True)
class SessionProgress:
    """Trials of a session in order, and the numbers of the accepted and skipped ones."""

    trials: tuple[PlannedTake, ...]
    accepted: frozenset[int] = frozenset()
    skipped: frozenset[int] = frozenset()

    @property
    def left(self) -> tuple[PlannedTake, ...]:
        """Trials that remain."""
        return tuple(t for t in self.trials if t.number not in self.accepted | self.skipped)


def progress_of(plan: SessionPlan, session: str, journal: Journal, store: Store | None) -> SessionProgress:
    """Return a session's progress, from its journal and the store.

    A session without accepted or skipped trials may be restarted with another plan; any other raises `DataError`.
    """
    trials = plan.trials()
    taken = [] if store is None else [info for info in store.index if info.session == session]
    if begun := journal.of("begun"):
        if begun[-1]["plan"] != plan.sha256:
            if not taken and not journal.of("skipped"):
                return SessionProgress(trials, frozenset(), frozenset())
            raise DataError(
                journal.folder,
                f"session {session!r} was begun with another plan; continue with that plan "
                f"(recorded in {journal.path}), or choose another name for the session",
            )
        # The recorded order: another version of numpy may draw another order from the same seed.
        trials = tuple(PlannedTake(**entry) for entry in begun[-1]["order"])
    accepted = {int(info.labels["trial"]) for info in taken if info.labels.get("plan") == plan.sha256[:16]}
    skipped = {int(entry["trial"]) for entry in journal.of("skipped")} - accepted
    return SessionProgress(trials, frozenset(accepted), frozenset(skipped))


class RecordingSession:
    """Run of a plan with an open source and journal.

    ``store`` is created with the first take. ``on_trial`` is called before each trial, so that a simulated device plays
    its material. With ``recognise``, each take is shown with its most probable material. ``log`` is the name of the
    source's raw log in the session's folder, ``clock`` a function like ``time.monotonic``.
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
        self._metronome = metronome or Metronome()
        self._recognise, self._on_trial, self._log, self._clock = recognise, on_trial, log, clock
        self._feed = Feed(source, reference_rate=plan.rate, full_scale=plan.limits.full_scale, clock=clock)
        self._place, self._notes_said = "", 0
        self._lost: TactogramError | None = None
        opened, removed = recover_store(store)
        if removed:
            console.say(f"{store}: removed leftovers of an interrupted session ({', '.join(removed)})")
        self.progress = progress_of(plan, name, journal, opened)
        if opened is not None and self._feed.reference_rate is None:
            self._feed.reference_rate = self._earlier_rate(opened)
        self.counts = {"accepted": 0, "redone": 0, "skipped": 0}

    def run(self) -> dict[str, Any]:
        """Record the remaining trials, until the experimenter stops or the source ends.

        Returns ``accepted``, ``redone``, ``skipped`` (in this run), ``left`` and ``stopped`` (why it ended early, or
        None). Raises `SourceLost` if the source disappeared; accepted takes are in the store.
        """
        begun = self._journal.of("begun")
        if not begun or begun[-1]["plan"] != self.plan.sha256:
            order = [vars(trial) for trial in self.progress.trials]
            values = self.plan.model_dump(mode="json")
            self._journal.write("begun", {"plan": self.plan.sha256, "order": order, "values": values})
        done = len(self.progress.accepted)
        if done or self.progress.skipped:
            self._console.say(
                f"continuing session {self.name}: {done} of {len(self.progress.trials)} takes are in the store, "
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
                f"{error}; {self.counts['accepted']} takes of this run are in {self.store_path}: connect it and "
                "start the session again to continue"
            ) from error
        finally:
            self._metronome.stop()
        left = len(self.progress.left) - self.counts["accepted"] - self.counts["skipped"]
        self._note("closed", {"left": left, "why": stopped})
        return {**self.counts, "left": left, "stopped": stopped}

    def _earlier_rate(self, store: Store) -> float | None:
        """Return the rate of this session's takes in the store, None if there are none."""
        for info in store.index:
            if info.session == self.name:
                return store.rate(info.id, next(s for s in store.streams_of(info.id) if s != RECEIVED))
        return None

    def _trial(self, trial: PlannedTake) -> bool:
        """Record one trial; return False to stop the session."""
        force = f", {self.plan.force_n:g} N" if self.plan.force_n is not None else ""
        self._place = f"take {trial.number} of {len(self.progress.trials)}: {trial}{force}"
        if self._on_trial is not None:
            self._on_trial(trial)
        attempt = 1 + sum(entry["trial"] == trial.number for entry in self._journal.of("take"))
        automatic = 1
        begun = self._ask(self._place, BEGIN, default="b")
        while begun == "b":
            take = self._record(trial)
            verdict = self._check(take)
            facts = {"trial": trial.number, "attempt": attempt, "first_index": take.first_index}
            facts |= {"samples": len(take), "lost": take.lost, "rate": take.rate, "verdict": verdict.facts()}
            default = "a" if verdict.good else "r" if automatic < MOST_REDONE else "s"
            question = f"{self._place}: {verdict}{self._recognised(take)}"
            decision = self._decide(trial, take, verdict, question=question, default=default)
            self._console.say(f"{question} -> {DECIDE[decision]}")
            self._note("take", facts | {"decision": DECIDE[decision], "log": self._log})
            if decision == "a":
                self.counts["accepted"] += 1
                # All takes of a session have one nominal rate: a crystal varies less than its measurement.
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
        plan, feed = self.plan, self._feed
        if self._lost is not None:
            raise self._lost
        feed.release()
        end = self._clock() + plan.countdown_s
        while (remaining := end - self._clock()) > 0:
            feed.poll(min(0.1, remaining))
            self._show("countdown", f"{remaining:.1f} s", 1 - remaining / max(plan.countdown_s, 1e-9))
        # The number of samples in a take depends on the rate.
        while feed.rate is None or not feed.next_index:
            feed.poll()
            self._show("waiting", "for the source and its rate", 0.0)
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
        return max(1, round(self.plan.seconds * (self._feed.rate or 1.0)))

    def _check(self, take: Take) -> TakeAssessment:
        return check_take(
            take,
            self.plan.limits,
            seconds=self.plan.seconds,
            nominal=self._feed.reference_rate,
            full_scale=self._feed.full_scale,
        )

    def _recognised(self, take: Take) -> str:
        """Return the most probable material of a take, as the end of a line."""
        if self._recognise is None or take.lost == len(take):
            return ""
        try:
            shares = self._recognise(Signal(bridged(take.samples)[0], take.rate, take.unit, take.axes))
        except TactogramError as error:
            return f"; not classified: {error}"
        name = max(shares, key=lambda material: shares[material])
        return f"; classified as {name} ({shares[name]:.2f})"

    def _decide(
        self, trial: PlannedTake, take: Take, verdict: TakeAssessment, *, question: str, default: str
    ) -> str:
        """Return the decision on a take; after ``"a"`` it is in the store.

        Raises the `OSError` for which a take was not stored, if the session then ends.
        """
        full: OSError | None = None
        while True:
            decision = self._ask(question, DECIDE, default=default)
            if decision == "q" and full is not None:
                raise full
            if decision != "a":
                return decision
            try:
                self._accept(trial, take, verdict)
            except (OSError, DataError) as error:
                why = one_line(error)
                self._console.say(
                    f"NOT stored: {why}; the store is unchanged, and the take is still available"
                )
                full = error if isinstance(error, OSError) else None
                default = "q" if full else "r"
            else:
                return decision

    def _accept(self, trial: PlannedTake, take: Take, verdict: TakeAssessment) -> None:
        """Write a take to the store; it is on the disk when this returns.

        Raises `OSError` if the disk is full, `DataError` if all samples were lost or are already in the store.
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
        facts = self._source.facts()
        recording = recording_of(
            take,
            stream=plan.stream,
            what=what,
            simulated=bool(facts.get("simulated")),
            notes=facts.get("notes", ()),
        )
        append_recording(
            self.store_path,
            recording,
            name=self.store_path.name,
            licence=plan.licence,
            source=f"capture: {plan.title}".removesuffix(": "),
        )

    def _ask(self, question: str, keys: Mapping[str, str], *, default: str) -> str:
        """Ask, and read the source meanwhile, since unread samples pile up in the cable."""
        self._console.show(CaptureStatus(self._place, "question", question, levels=self._feed.levels()))

        def read() -> None:
            # The take in question survives a source that disappears now: the error is raised before the next one.
            if self._lost is not None:
                sleep(0.05)
                return
            try:
                self._feed.poll(0.05, patient=True)
            except TactogramError as error:
                self._lost = error
            self._show("question", question, 0.0)

        return self._console.ask(question, keys, default=default, idle=read)

    def _show(self, phase: str, text: str, share: float) -> None:
        notes = getattr(self._source, "notes", ())
        for note in notes[self._notes_said :]:
            self._console.say(f"note: {note}")
        self._notes_said = len(notes)
        self._console.show(CaptureStatus(self._place, phase, text, share, self._feed.levels()))

    def _note(self, event: str, facts: Mapping[str, Any]) -> None:
        """Write to the journal; if the disk is full, the session continues, since only the store is essential."""
        try:
            self._journal.write(event, facts)
        except OSError as error:
            self._console.say(f"the journal could not be written: {one_line(error)}")
