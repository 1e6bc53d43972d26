from tactogram_studio.tasks.log import (
    checkpoint_position,
)
from tactogram_studio.workspace.commands import command_line, free_name


def test_names_are_unused_and_commands_are_quoted(tmp_path):
    (tmp_path / "a").mkdir()
    assert free_name(tmp_path, "a") == "a-2"
    assert free_name(tmp_path, "b") == "b"
    assert command_line(["train", "x", "--out", "my run"]) == "tactogram train x --out 'my run'"
    assert checkpoint_position(tmp_path) is None
