import numpy as np
import pytest
from laboratory_files import tone

from tactogram.datasets import Recording, RecordingInfo, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Image
from tactogram.signal.io import write_signal
from tactogram.workflows.data.stores import add_signal
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.recordings import (
    RecordingFilter,
    choices,
    describe_recording,
    filtered,
    open_named,
    page_bounds,
    thumbnail,
    trace_svg,
)


def test_recordings_are_filtered_and_paged(tones):
    index = tones.index
    assert len(filtered(index, RecordingFilter(text="TONES tone-100"))) == 2
    assert len(filtered(index, RecordingFilter(material="tone-50"))) == 1
    assert len(filtered(index, RecordingFilter(fields={"speed_mm_s": "100", "session": "day 1"}))) == 2
    assert choices(index) == {"session": ["day 0", "day 1"], "speed_mm_s": ["50", "100", "200"]}
    assert page_bounds(45, 3, 20) == (3, 40, 45)
    assert page_bounds(45, 99, 20) == (3, 40, 45)
    assert page_bounds(0, 1, 20) == (1, 0, 0)
    known = dict(
        describe_recording(RecordingInfo(id="a", material="x", speed_mm_s=50.0, labels={"lab": "b"}))
    )
    assert (known["speed"], known["lab"], known["source"]) == ("50 mm/s", "b", "unknown")


def test_small_pictures_have_the_expected_format_and_size(tmp_path):
    picture = trace_svg(tone(10, seconds=8.0)).decode()
    assert picture.startswith("<svg")
    assert picture.count(",") == 2 * 240
    store = create_store(
        tmp_path / "set",
        [
            Recording(
                streams={"acceleration": tone(50)},
                material="red",
                image=Image(np.full((40, 60, 3), (200, 0, 0), np.uint8)),
            )
        ],
        name="set",
        licence="made in a test",
    )
    [key] = store.photograph_keys()
    assert thumbnail(store, key, size=32)[:2] == b"\xff\xd8"
    with pytest.raises(ParameterError, match="size must be 16 to 1024"):
        thumbnail(store, key, size=5000)


def test_a_store_is_reopened_after_an_addition(tones, tmp_path):
    workspace = Workspace.at(tmp_path)
    first = open_named(workspace, "tones")
    assert open_named(workspace, "tones") is first
    write_signal(tmp_path / "a.wav", tone(70))
    add_signal(tmp_path / "tones", tmp_path / "a.wav", material="tone-70")
    assert len(open_named(workspace, "tones")) == len(first) + 1
    with pytest.raises(ParameterError, match="outside"):
        open_named(workspace, "../tones")
