import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_studio.tasks.live_choices import (
    confine_address,
    plan_choices,
    session_state,
    source_choices,
    without_materials,
)
from tactogram_studio.workspace.folder import Workspace


@pytest.fixture(name="plan")
def plan_fixture(tmp_path):
    """Give a plan of two short takes."""
    path = tmp_path / "tiny.toml"
    path.write_text(
        'title = "Tiny"\nmaterials = ["one", "two"]\nseconds = 0.3\ncountdown_s = 0\norder = "as-listed"\nrate = 330\n'
        "[limits]\nmost_lost = 1.0\nlongest_gap_s = 5.0\n"
    )
    return path


def test_simulated_sources_are_always_there(surfaces):
    workspace = Workspace.at(surfaces)
    missing = {
        "kind": "lsl",
        "address": None,
        "what": "Lab Streaming Layer stream",
        "missing": "install pylsl",
    }
    found = source_choices(workspace, [missing])
    assert (found[0].address, found[0].missing) == (None, "install pylsl")
    addresses = [choice.address for choice in found if choice.simulated]
    assert "played:studio/first/surfaces?rate=330&loss=0.01&materials=all" in addresses
    assert any(address.startswith("simulated:twelite") for address in addresses)
    assert without_materials(addresses[0]) == "played:studio/first/surfaces?rate=330&loss=0.01"


@pytest.mark.parametrize(
    "address",
    [
        "played:../store",
        "log:/etc/passwd",
        "twelite:/dev/x?log=/tmp/raw.log",
        "simulated:twelite?rate=330&file=..%2Fx.npz",
    ],
)
def test_a_source_reads_and_writes_nothing_outside_of_the_workspace(tmp_path, address):
    with pytest.raises(ParameterError, match="outside"):
        confine_address(Workspace.at(tmp_path), address)


def test_a_confined_address_stays_what_it_is(tmp_path):
    workspace = Workspace.at(tmp_path)
    assert confine_address(workspace, "serial:/dev/ttyACM0?unit=g") == "serial:/dev/ttyACM0?unit=g"
    assert confine_address(workspace, "played:s?loss=0.1") == f"played:{tmp_path / 's'}?loss=0.1"


def test_plans_of_the_workspace_are_found(tmp_path, plan):
    workspace = Workspace.at(tmp_path)
    assert plan_choices(workspace)["tiny.toml"] == "tiny.toml: Tiny"
    assert "first-try" in plan_choices(workspace)


def test_a_session_that_is_none_has_no_state(tmp_path):
    workspace = Workspace.at(tmp_path)
    assert session_state(workspace, "rec", "none") is None
    with pytest.raises((ParameterError, DataError)):
        session_state(workspace, "../rec", "none")
