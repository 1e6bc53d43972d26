"""Sources, plans and sessions that the page Live offers for a workspace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from tactogram.datasets import open_store
from tactogram.errors import DataError, TactogramError
from tactogram.text_files import parse_json, read_text
from tactogram_capture.catalogue import parse_address
from tactogram_capture.session.journal import FILE as JOURNAL
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_studio.workspace.folder import Workspace

SIMULATED = "simulated:twelite?rate=330&loss=0.02"


@dataclass(frozen=True)
class SourceChoice:
    """A source to record from; without an ``address``, ``missing`` is the reason in one line."""

    address: str | None
    description: str
    missing: str | None = None
    simulated: bool = False


def source_choices(workspace: Workspace, sources: list[dict[str, Any]]) -> list[SourceChoice]:
    """Return the devices among ``sources`` (of `find_sources`), then the simulated sources."""
    devices = [
        SourceChoice(
            entry["address"],
            entry["what"],
            entry["missing"]
            or (None if entry["address"] else f"{entry['what']}: plug it in and look for devices again"),
        )
        for entry in sources
        if not entry.get("simulated")
    ]
    stores = [workspace.name_of(store) for store in workspace.stores() if _can_be_played(store)]
    simulated = [
        SourceChoice(
            f"played:{name}?rate=330&loss=0.01&materials=all",
            f"recordings of {name} through a simulated TWE-Lite receiver",
            simulated=True,
        )
        for name in stores
    ]
    receiver = SourceChoice(SIMULATED, "simulated TWE-Lite receiver stroking a noise texture", simulated=True)
    return [*devices, *simulated, receiver]


def confine_address(workspace: Workspace, address: str) -> str:
    """Return an address with full paths; `ParameterError` if it is invalid or names a file outside of the workspace."""
    kind, place, _ = parse_address(address)
    head, sign, query = address.partition("?")
    if kind.place_is_file and place:
        head = f"{kind.name}:{workspace.inside(place)}"
    pairs = []
    for pair in query.split("&") if sign else []:
        name, equals, value = pair.partition("=")
        if name in kind.file_options():
            value = quote(str(workspace.inside(unquote(value))))
        pairs.append(f"{name}{equals}{value}")
    return head + sign + "&".join(pairs)


def without_materials(address: str) -> str:
    """Return the address of played recordings without their materials, which a session sets itself."""
    head, sign, query = address.partition("?")
    if not head.startswith("played:") or not sign:
        return address
    rest = "&".join(pair for pair in query.split("&") if not pair.startswith("materials="))
    return f"{head}?{rest}" if rest else head


def plan_choices(workspace: Workspace) -> dict[str, str]:
    """Return the titles of session plans, by name or by file relative to the workspace."""
    titles = {name: SessionPlan.load(name).title or name for name in shipped_plans()}
    for path, values in workspace.toml_files():
        if "materials" not in values:
            continue
        try:
            title = SessionPlan.load(path).title
        except TactogramError:
            continue
        name = workspace.name_of(path)
        titles[name] = f"{name}: {title}" if title else name
    return titles


def session_state(workspace: Workspace, data: str, session: str) -> Mapping[str, Any] | None:
    """Return a session's ``total``, ``accepted``, ``skipped`` and ``left`` takes, and whether it is ``open``.

    None if there is no such session. The store decides which takes are accepted, whatever the journal says.
    """
    store = workspace.inside(data)
    journal = workspace.inside(store.with_name(f"{store.name}.sessions") / session / JOURNAL)
    try:
        lines = read_text(journal).split("\n")[:-1]  # the last line may be cut short
        events = [parse_json(line, journal) for line in lines]
        begun = [event for event in events if event["event"] == "begun"]
        if not begun:
            return None
        total, plan = len(begun[-1]["order"]), str(begun[-1]["plan"])[:16]
        skipped = {int(event["trial"]) for event in events if event["event"] == "skipped"}
    except (DataError, KeyError, TypeError, ValueError):
        return None
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
    skipped -= accepted
    return {
        "total": total,
        "accepted": len(accepted),
        "skipped": len(skipped),
        "left": total - len(accepted) - len(skipped),
        "open": events[-1]["event"] != "closed",
    }


def _can_be_played(store: Path) -> bool:
    """Return whether a store has three axes in m/s^2, which the simulated receiver sends."""
    try:
        facts = open_store(store).streams.get("acceleration")
    except TactogramError:
        return False
    return facts is not None and facts.unit == "m/s^2" and set(facts.axes) == {"x", "y", "z"}
