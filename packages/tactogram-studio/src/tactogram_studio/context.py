"""Context shared by all pages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive
from tactogram_studio.workspace.starter_data import StarterData
from tactogram_study.participants.sessions import SessionRegistry


@dataclass(frozen=True)
class Studio:
    """A studio on a workspace.

    Parameters
    ----------
    workspace : Workspace
    shelf : ResultArchive
        Kept results.
    starter : StarterData
        Simulated example surfaces for a workspace without runs.
    sessions : SessionRegistry
        Open study sessions.
    study_only : bool
        Whether a single study is served, without the studio's pages.
    roots : tuple of str
        Beginnings of the addresses under which other machines reach the server, best first; empty on loopback.
    """

    workspace: Workspace
    shelf: ResultArchive
    starter: StarterData
    sessions: SessionRegistry
    study_only: bool = False
    roots: tuple[str, ...] = ()

    @classmethod
    def at(cls, folder: Path | str, *, study_only: bool = False) -> Studio:
        """Return the studio on a folder."""
        workspace = Workspace.at(folder)
        return cls(
            workspace,
            ResultArchive(workspace.studio_folder / "kept"),
            StarterData(workspace.studio_folder / "first"),
            SessionRegistry(workspace.folder),
            study_only,
        )
