import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio import study_server


def test_a_study_that_cannot_be_served_is_refused_before_it_is_workspace_sessions(tmp_path, monkeypatch):
    monkeypatch.setattr(study_server, "serve", lambda *_, **__: pytest.fail("served"))
    with pytest.raises(ParameterError, match="no such study"):
        study_server.run_study("nothing", tmp_path / "session", None)
    with pytest.raises(ParameterError, match="a new session of a study needs out"):
        study_server.run_study("abx", None, None)
    with pytest.raises(DataError, match="no study was begun here"):
        study_server.run_study(tmp_path, None, None)
    with pytest.raises(ParameterError, match="never a name"):
        study_server.run_study("abx", tmp_path / "session", None, codes=["Hanako"])
    with pytest.raises(ParameterError, match="full scale"):
        study_server.run_study(
            "abx", tmp_path / "session", None, changes={"played_by": "server", "display": "voice-coil"}
        )
    assert not (tmp_path / "session").exists()
