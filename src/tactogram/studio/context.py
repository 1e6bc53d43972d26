"""Context that every page is given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tactogram.studio.participants.sessions import SessionRegistry
from tactogram.studio.workspace.folder import Workspace
from tactogram.studio.workspace.shelf import ResultArchive
from tactogram.studio.workspace.starter_data import StarterData


@dataclass(frozen=True)
class Studio:
    """A studio on a workspace.

    Parameters
    ----------
    workspace : Workspace
    shelf : Shelf
        Kept results.
    first : FirstVoices
        Something to play with where no run is.
    sessions : Sessions
        Studies that are being taken.
    alone : bool
        Whether one study is served, without the studio's other pages.
    roots : tuple of str
        How the addresses begin by which other machines reach it, the best first; none where only this one does.
    """

    workspace: Workspace
    shelf: ResultArchive
    first: StarterData
    sessions: SessionRegistry
    alone: bool = False
    roots: tuple[str, ...] = ()

    @classmethod
    def at(cls, folder: Path | str, *, alone: bool = False) -> Studio:
        """Return the studio on a folder."""
        workspace = Workspace.at(folder)
        return cls(
            workspace,
            ResultArchive(workspace.own / "kept"),
            StarterData(workspace.own / "first"),
            SessionRegistry(workspace.folder),
            alone,
        )
