"""View of a session for the experimenter: pure functions of the store's content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tactogram.study.answers import Answer
from tactogram.study.session.states import NOT_BEGUN, status_counts
from tactogram.study.session.store import SessionStore

LATEST = 15
"""Answers that are shown as they come."""
QUIET_S = 120.0
"""After which a participant who is going on is marked: something may be wrong."""
DEVICE = (
    ("px_per_mm", "{} px/mm"),
    ("refresh_hz", "{} Hz"),
    ("target_speed_mm_s", "target {} mm/s"),
    ("finger_speed_mm_s", "finger {} mm/s"),
    ("audio_latency_ms", "sound {} ms late"),
    ("pointer", "{}"),
)
"""Facts of a device that are shown, and how."""


@dataclass(frozen=True)
class ParticipantRow:
    """One participant, as the page shows them.

    Parameters
    ----------
    code : str
    simulated : bool
    status : str
        One of `tactogram.study.session.states.STATES`.
    where, since, device : str
    share : float
        Of the trials that are done.
    quiet : bool
        Whether nothing came for long from someone who is going on.
    """

    code: str
    simulated: bool
    status: str
    where: str
    since: str
    device: str
    share: float
    quiet: bool


@dataclass(frozen=True)
class SessionView:
    """A session at one moment.

    Parameters
    ----------
    rows : tuple of Row
    notes : tuple of mapping
    latest : tuple of Answer
        The last ones to trials, newest first.
    ended : str or None
    withdrawn, answers : int
    """

    rows: tuple[ParticipantRow, ...]
    notes: tuple[Mapping[str, Any], ...]
    latest: tuple[Answer, ...]
    ended: str | None
    withdrawn: int
    answers: int

    @property
    def unfinished(self) -> int:
        """How many may still answer: who is going on, and who has not begun."""
        return self.going + self.not_begun

    @property
    def going(self) -> int:
        """How many began and are not at the end."""
        return sum(row.status == "active" for row in self.rows)

    @property
    def not_begun(self) -> int:
        """How many were enrolled and answered nothing yet."""
        return sum(row.status == NOT_BEGUN for row in self.rows)

    @property
    def simulated(self) -> bool:
        """Whether simulated participants are among them."""
        return any(row.simulated for row in self.rows)

    def summary(self) -> str:
        """Return in a line how far all are."""
        kind = f"{'simulated ' if self.simulated else ''}participant{'' if len(self.rows) == 1 else 's'}"
        stand = status_counts(row.status for row in self.rows)
        parts = [f"{len(self.rows)} {kind}", *([stand] if stand else [])]
        parts += [f"{self.withdrawn} withdrew"] if self.withdrawn else []
        return f"{', '.join(parts)}; {self.answers} answers"


def view_of(store: SessionStore, *, now: datetime | None = None) -> SessionView:
    """Return what the page shows of a session."""
    moment = now or datetime.now(UTC)
    rows = tuple(_row(one, store.device(one["participant"]), moment) for one in store.progress())
    latest = [row for row in store.latest(3 * LATEST) if row.design != "questions"]
    return SessionView(
        rows, tuple(store.notes()), tuple(latest[:LATEST]), store.ended, store.withdrawn, store.count
    )


def _row(known: Mapping[str, Any], device: Mapping[str, Any], now: datetime) -> ParticipantRow:
    status = str(known["status"])
    silent = (
        None
        if known["last"] is None
        else max(0.0, (now - datetime.fromisoformat(known["last"])).total_seconds())
    )
    return ParticipantRow(
        known["participant"],
        known["simulated"],
        status,
        place_text(known),
        since_text(silent),
        device_text(device),
        share_of(known),
        status == "active" and silent is not None and silent > QUIET_S,
    )


def share_of(known: Mapping[str, Any]) -> float:
    """Return how much a participant has done, 0 to 1; who has finished has done all, however short a staircase was."""
    return 1.0 if known["status"] == "finished" else float(known["trials"] / max(1, known["of"]))


def place_text(known: Mapping[str, Any]) -> str:
    """Return where a participant is: ``trial 13 of 90``."""
    page = known["page"]
    if known["status"] == "finished" or page is None:
        return f"{known['trials']} trials done"
    if page.startswith("practice-"):
        return f"practice {page.removeprefix('practice-').partition('.')[0]}"
    if page.startswith("trial-"):
        return f"trial {page.removeprefix('trial-').partition('.')[0]} of {known['of']}"
    texts = {"consent": "consent not answered yet", "before": "questions before", "after": "questions after"}
    return texts.get(page, str(page))


def since_text(seconds: float | None) -> str:
    """Return how long ago an answer came."""
    if seconds is None:
        return "no answer yet"
    if seconds < 60:
        return f"{seconds:.0f} s ago"
    if seconds < 3600:
        return f"{seconds / 60:.0f} min ago"
    return f"{seconds / 3600:.0f} h ago" if seconds < 172_800 else f"{seconds / 86_400:.0f} days ago"


def device_text(facts: Mapping[str, Any]) -> str:
    """Return what a device said, in a line; speeds of several areas are joined."""
    said = []
    for name, form in DEVICE:
        values = [facts[key] for key in (f"{name}_a", f"{name}_b") if key in facts]
        values = values or ([facts[name]] if name in facts else [])
        if values:
            said.append(form.format(" and ".join(_short(value) for value in values)))
    return ", ".join(said)


def peeking_text(view: SessionView) -> str:
    """Return what is said before results are looked at while people still take part; "" where nobody does."""
    if not view.unfinished or view.ended:
        return ""
    left = ((view.going, "finished"), (view.not_begun, "begun"))
    who = " and ".join(f"{count} {'has' if count == 1 else 'have'} not {how}" for count, how in left if count)
    return (
        f"Of {len(view.rows)} enrolled, {who}; the study was not ended. Who looks at results "
        "and decides by them whether to go on finds differences by chance more often than alpha says. That the "
        "analysis was looked at will be noted."
    )


def folder_of(session: str) -> str:
    """Return the folder, relative to the workspace, that an address names."""
    return session.replace("~", "/")


def address_of(name: str) -> str:
    """Return the address of a session's page from its folder relative to the workspace."""
    return f"/experiment/{name.replace('/', '~')}"


def report_of(folder: Path) -> Path:
    """Return where a session's report is written."""
    return folder / "analysis" / "report.html"


def answers_rows(latest: Sequence[Answer]) -> list[list[str]]:
    """Return the last answers without what would tell how the study comes out: no condition, no right or wrong."""
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
