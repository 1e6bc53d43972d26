"""Choices of the page Live: sources, classifiers, session plans, and progress of sessions."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from tactogram import models
from tactogram.capture.catalogue import parsed
from tactogram.capture.session.journal import FILE as DIARY
from tactogram.capture.session.plan import SessionPlan, shipped_plans
from tactogram.datasets import open_store
from tactogram.errors import TactogramError
from tactogram.studio.workspace.folder import Workspace

SIMULATED = "simulated:twelite?rate=330&loss=0.02"


@dataclass(frozen=True)
class SourceChoice:
    """A source that can be opened, or why there is none of its kind.

    Parameters
    ----------
    address : str or None
    what : str
    missing : str or None
        One line: what is not installed or not plugged in.
    simulated : bool
    """

    address: str | None
    what: str
    missing: str | None = None
    simulated: bool = False


def source_choices(workspace: Workspace, found: list[dict[str, Any]]) -> list[SourceChoice]:
    """Return what can be recorded from: devices, then the simulated ones, which are always there.

    Parameters
    ----------
    workspace : Workspace
    found : list of dict
        As `tactogram.workflows.capture.logs.list_sources` gives it.
    """
    devices = [
        SourceChoice(
            entry["address"],
            entry["what"],
            entry["missing"] or (None if entry["address"] else f"{entry['what']}: plug it in and look again"),
        )
        for entry in found
        if entry["kind"] != "simulated"
    ]
    simulated = [
        SourceChoice(
            f"played:{workspace.name_of(store)}?rate=330&loss=0.01&materials=all",
            f"recordings of {workspace.name_of(store)}, through a simulated TWE-Lite receiver",
            simulated=True,
        )
        for store in workspace.stores()
        if _can_be_played(store)
    ]
    receiver = SourceChoice(SIMULATED, "simulated TWE-Lite receiver that strokes noise", simulated=True)
    return [*devices, *simulated, receiver]


def confined(workspace: Workspace, address: str) -> str:
    """Return an address whose files lie in the workspace, by whole paths.

    Raises
    ------
    ParameterError
        If it is no address, or one of its files lies outside.
    """
    kind, place, _ = parsed(address)
    head, sign, query = address.partition("?")
    if kind in ("played", "log") and place:
        head = f"{kind}:{workspace.inside(place)}"
    pairs = []
    for pair in query.split("&") if sign else []:
        name, equals, value = pair.partition("=")
        if name in ("file", "log"):
            value = quote(str(workspace.inside(unquote(value))))
        pairs.append(f"{name}{equals}{value}")
    return head + sign + "&".join(pairs)


def needs_material(address: str) -> str:
    """Return an address of recordings that are played without what is stroked: a session says that."""
    head, sign, query = address.partition("?")
    if not head.startswith("played:") or not sign:
        return address
    rest = "&".join(pair for pair in query.split("&") if not pair.startswith("materials="))
    return f"{head}?{rest}" if rest else head


def classifiers(workspace: Workspace) -> dict[str, str]:
    """Return the finished runs of classifiers: what they know, by folder relative to the workspace."""
    known, found = models.available(), {}
    for run in workspace.finished_runs():
        try:
            facts = json.loads((run / "model.json").read_text(encoding="utf-8"))
            model = tomllib.loads((run / "recipe.toml").read_text(encoding="utf-8")).get("model")
        except (OSError, ValueError):
            continue
        if model in known and known[model].task == "classification":
            name = workspace.name_of(run)
            count = len(facts.get("kind", {}).get("materials", ()))
            found[name] = f"{name} ({count} materials)" if count else name
    return found


def plan_choices(workspace: Workspace) -> dict[str, str]:
    """Return session plans by name or by file relative to the workspace: a line on each."""
    found = {name: SessionPlan.load(name).title or name for name in shipped_plans()}
    for path in workspace.files(".toml"):
        try:
            if (
                "materials" not in tomllib.loads(path.read_text(encoding="utf-8"))
                or path.stat().st_size > 1e6
            ):
                continue
            title = SessionPlan.load(path).title
        except (OSError, ValueError, TactogramError):
            continue
        name = workspace.name_of(path)
        found[name] = f"{name}: {title}" if title else name
    return found


def session_state(workspace: Workspace, data: str, session: str) -> Mapping[str, Any] | None:
    """Return how far a session is: ``total``, ``accepted``, ``skipped``, ``left``, ``open`` (if it was not ended).

    None where there is none. What was accepted stands in the store, whatever the diary says.
    """
    store = workspace.inside(data)
    diary = workspace.inside(store.with_name(f"{store.name}.sessions") / session / DIARY)
    try:
        lines = diary.read_text(encoding="utf-8").split("\n")[:-1]
        events = [json.loads(line) for line in lines]
    except (OSError, ValueError):
        return None
    begun = [event for event in events if event["event"] == "begun"]
    if not begun:
        return None
    total, plan = len(begun[-1]["order"]), str(begun[-1]["plan"])[:16]
    accepted: set[int] = set()
    try:
        index = open_store(store).index if store.is_dir() else ()
        accepted = {
            int(info.labels["trial"])
            for info in index
            if info.session == session and info.labels.get("plan") == plan
        }
    except TactogramError:
        pass
    skipped = {int(event["trial"]) for event in events if event["event"] == "skipped"} - accepted
    return {
        "total": total,
        "accepted": len(accepted),
        "skipped": len(skipped),
        "left": total - len(accepted) - len(skipped),
        "open": events[-1]["event"] != "closed",
    }


def _can_be_played(store: Path) -> bool:
    """Return whether a store holds three axes in m/s^2, which is what the simulated receiver sends."""
    try:
        facts = open_store(store).streams.get("acceleration")
    except TactogramError:
        return False
    return facts is not None and facts.unit == "m/s^2" and set(facts.axes) == {"x", "y", "z"}
