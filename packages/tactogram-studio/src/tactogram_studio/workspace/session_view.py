"""The experimenter's view of a session: pure functions of the store's content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tactogram_study.answers import Answer
from tactogram_study.session.progress import NOT_BEGUN, status_counts
from tactogram_study.session.store import SessionStore

LATEST = 15
"""Latest answers in the view."""
QUIET_S = 120.0
"""An active participant without an answer for so long is highlighted."""
DEVICE = (
    ("px_per_mm", "{} px/mm"),
    ("refresh_hz", "{} Hz"),
    ("target_speed_mm_s", "target {} mm/s"),
    ("finger_speed_mm_s", "finger {} mm/s"),
    ("audio_latency_ms", "sound {} ms late"),
    ("pointer", "{}"),
)
"""Facts of a device in the view, and their form."""


@dataclass(frozen=True)
class ParticipantRow:
    """One participant in the view.

    ``status`` is one of `tactogram_study.session.progress.STATES`, ``share`` that of trials done; ``quiet`` marks an
    active participant without an answer for `QUIET_S`.
    """

    code: str
    simulated: bool
    status: str
    place: str
    since: str
    device: str
    share: float
    quiet: bool


@dataclass(frozen=True)
class SessionView:
    """A session at one moment; ``latest`` holds answers to trials, newest first."""

    rows: tuple[ParticipantRow, ...]
    notes: tuple[Mapping[str, Any], ...]
    latest: tuple[Answer, ...]
    ended: str | None
    withdrawn: int
    answers: int

    @property
    def unfinished(self) -> int:
        """Participants who may still answer."""
        return self.active + self.not_begun

    @property
    def active(self) -> int:
        """Participants who have begun and not finished."""
        return sum(row.status == "active" for row in self.rows)

    @property
    def not_begun(self) -> int:
        """Participants who are enrolled and have not answered anything."""
        return sum(row.status == NOT_BEGUN for row in self.rows)

    @property
    def simulated(self) -> bool:
        """Whether there are simulated participants."""
        return any(row.simulated for row in self.rows)

    def summary(self) -> str:
        """Return the progress of all participants in a line."""
        counts = status_counts(row.status for row in self.rows)
        withdrawn = f"{self.withdrawn} withdrew" if self.withdrawn else ""
        parts = [participant_count(len(self.rows), simulated=self.simulated), counts, withdrawn]
        return f"{', '.join(filter(None, parts))}; {self.answers} answers"


def view_of(store: SessionStore, *, now: datetime | None = None) -> SessionView:
    """Return the view of a session."""
    moment = now or datetime.now(UTC)
    rows = tuple(_row(person, store.device(person["participant"]), moment) for person in store.progress())
    latest = [row for row in store.latest(3 * LATEST) if row.design != "questions"]
    return SessionView(
        rows, tuple(store.notes()), tuple(latest[:LATEST]), store.ended, store.withdrawn, store.count
    )


def _row(progress: Mapping[str, Any], device: Mapping[str, Any], now: datetime) -> ParticipantRow:
    status, last = str(progress["status"]), progress["last"]
    silent = None if last is None else max(0.0, (now - datetime.fromisoformat(last)).total_seconds())
    return ParticipantRow(
        progress["participant"],
        progress["simulated"],
        status,
        place_text(progress),
        since_text(silent),
        device_text(device),
        share_of(progress),
        status == "active" and silent is not None and silent > QUIET_S,
    )


def participant_count(count: int, *, simulated: bool) -> str:
    """Return ``2 simulated participants``."""
    return f"{count} {'simulated ' if simulated else ''}participant{'' if count == 1 else 's'}"


def share_of(progress: Mapping[str, Any]) -> float:
    """Return the share of trials done; 1 for finished participants, however short their staircase was."""
    if progress["status"] == "finished":
        return 1.0
    return float(progress["trials"] / max(1, progress["of"]))


def place_text(progress: Mapping[str, Any]) -> str:
    """Return a participant's page: ``trial 13 of 90``."""
    page = progress["page"]
    if progress["status"] == "finished" or page is None:
        return f"{progress['trials']} trials done"
    if page.startswith("practice-"):
        return f"practice {page.removeprefix('practice-').partition('.')[0]}"
    if page.startswith("trial-"):
        return f"trial {page.removeprefix('trial-').partition('.')[0]} of {progress['of']}"
    texts = {"consent": "consent not given yet", "before": "questions before", "after": "questions after"}
    return texts.get(page, str(page))


def since_text(seconds: float | None) -> str:
    """Return the time since an answer."""
    if seconds is None:
        return "no answer yet"
    if seconds < 60:
        return f"{seconds:.0f} s ago"
    if seconds < 3600:
        return f"{seconds / 60:.0f} min ago"
    return f"{seconds / 3600:.0f} h ago" if seconds < 172_800 else f"{seconds / 86_400:.0f} days ago"


def device_text(facts: Mapping[str, Any]) -> str:
    """Return a device's facts in a line; speeds in several areas are joined."""
    texts = []
    for name, form in DEVICE:
        values = [facts[key] for key in (f"{name}_a", f"{name}_b") if key in facts]
        values = values or ([facts[name]] if name in facts else [])
        if values:
            texts.append(form.format(" and ".join(_short(value) for value in values)))
    return ", ".join(texts)


def peeking_text(view: SessionView) -> str:
    """Return the warning before an interim analysis; "" if nobody can answer any more."""
    if not view.unfinished or view.ended:
        return ""
    left = ((view.active, "finished"), (view.not_begun, "begun"))
    who = " and ".join(f"{count} {'has' if count == 1 else 'have'} not {how}" for count, how in left if count)
    return (
        f"Of {len(view.rows)} enrolled, {who}; the study has not ended. Deciding from interim results whether to "
        "continue finds differences by chance more often than alpha says. A note will record this look at the analysis."
    )


def folder_of(session: str) -> str:
    """Return the folder, relative to the workspace, that an address names."""
    return session.replace("~", "/")


def address_of(name: str) -> str:
    """Return the address of a session's page; ``name`` is its folder relative to the workspace."""
    return f"/experiment/{name.replace('/', '~')}"


def report_of(folder: Path) -> Path:
    """Return the file of a session's report."""
    return folder / "analysis" / "report.html"


def answers_rows(latest: Sequence[Answer]) -> list[list[str]]:
    """Return answers without conditions and correctness, which would reveal the result."""
    return [
        [
            row.participant,
            f"{'practice ' if row.design == 'practice' else ''}{row.trial}",
            row.question,
            row.answer,
            row.at[11:19],
        ]
        for row in latest
    ]


def _short(value: Any) -> str:
    if isinstance(value, list):
        return _short(sum(value) / len(value))
    return f"{value:.3g}" if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
