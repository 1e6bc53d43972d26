"""Previews of a study: how many stay open, and which files they may be of."""

from contextlib import closing

import pytest

from tactogram.errors import ParameterError
from tactogram_study.participants.sessions import MOST_PREVIEWS, SessionRegistry


def test_only_the_latest_previews_stay_open(tmp_path, make_study):
    study, path = make_study(), tmp_path / "small.toml"
    with closing(SessionRegistry(tmp_path)) as sessions:
        tickets = [
            sessions.preview(study, path).removeprefix("/take/").removesuffix("?preview")
            for _ in range(MOST_PREVIEWS + 1)
        ]
        assert [sessions.by_ticket(ticket) is not None for ticket in tickets] == [False] + [
            True
        ] * MOST_PREVIEWS


def test_no_preview_reads_files_from_elsewhere(tmp_path, make_study):
    study, path = make_study(), tmp_path / "small.toml"
    (tmp_path / "workspace").mkdir()
    with (
        closing(SessionRegistry(tmp_path / "workspace")) as sessions,
        pytest.raises(ParameterError, match="outside of the workspace"),
    ):
        sessions.preview(study, path)
