"""The application's cookies."""

import stat

from tactogram_studio.application import _cookie_secret, _session_cookie


def test_the_key_of_cookies_survives_a_restart_and_is_its_owners(tmp_path):
    key = _cookie_secret(tmp_path / "secret")
    assert len(key) >= 40
    assert _cookie_secret(tmp_path / "secret") == key
    assert stat.S_IMODE((tmp_path / "secret").stat().st_mode) == 0o600
    assert _cookie_secret(tmp_path / "other") != key


def test_over_https_the_session_is_never_sent_without():
    plain, secure = _session_cookie(https=False), _session_cookie(https=True)
    assert secure["https_only"] is True
    assert secure["session_cookie"].startswith("__Host-")
    assert "https_only" not in plain
    assert plain["same_site"] == secure["same_site"] == "strict"
