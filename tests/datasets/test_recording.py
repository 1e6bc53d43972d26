"""A recording: its id, its class, its order among others."""

import numpy as np
import pytest

from tactogram.datasets.recording import Recording, RecordingInfo, content_id, item_of, label_of, natural_key
from tactogram.errors import ParameterError
from tactogram.signal import Signal

FORCE = Signal([[1.0, 2.0]], 100.0, "N", ("z",))
SOUND = Signal([[0.5, 0.25]], 8000.0, "1", ("1",))


def test_the_id_is_of_the_streams_and_not_of_their_order():
    first = content_id({"force": FORCE, "sound": SOUND})
    assert first == content_id({"sound": SOUND, "force": FORCE})
    others = [
        {"push": FORCE, "sound": SOUND},
        {"force": FORCE},
        {"force": Signal(FORCE.samples, 100.5, "N", ("z",)), "sound": SOUND},
        {"force": Signal(FORCE.samples, 100.0, "1", ("z",)), "sound": SOUND},
        {"force": Signal(FORCE.samples, 100.0, "N", ("x",)), "sound": SOUND},
        {"force": Signal(FORCE.samples, 100.0, "N", ("z",), "displacement"), "sound": SOUND},
        {"force": FORCE.with_samples(np.nextafter(FORCE.samples, np.float32(9))), "sound": SOUND},
    ]
    assert len({first, *map(content_id, others)}) == 8
    assert len(first) == 16
    assert Recording(streams={"force": FORCE}, material="cork").id == content_id({"force": FORCE})


def test_what_is_known_is_kept_without_the_samples():
    recording = Recording(streams={"force": FORCE}, material="cork", speed_mm_s=50.0, labels={"trial": "2"})
    assert type(recording.info) is RecordingInfo
    assert (recording.info.material, recording.info.speed_mm_s, recording.info.labels) == (
        "cork",
        50.0,
        {"trial": "2"},
    )
    assert recording.info.id == recording.id
    assert recording.stream("force") is FORCE
    with pytest.raises(ParameterError, match="stream must be one of force, got 'sound'"):
        recording.stream("sound")
    with pytest.raises(ParameterError, match="at least one stream"):
        Recording(streams={})


def test_numbers_in_names_are_in_numerical_order():
    assert sorted(["take10", "take9b", "take9", "9", "Take1", "take"], key=natural_key) == [
        "9",
        "Take1",
        "take",
        "take9",
        "take9b",
        "take10",
    ]


@pytest.mark.parametrize(
    ("label", "of_all", "of_none"),
    [
        ("material", "cork", None),
        ("material+contactor", "cork-pen", None),
        ("item", "cork, wet", None),
        (lambda info: info.session, "monday", None),
    ],
)
def test_the_class_is_what_was_asked_for(label, of_all, of_none):
    known = RecordingInfo(
        id="1", material="cork", contactor="pen", session="monday", labels={"item": "cork, wet"}
    )
    assert label_of(known, label) == of_all
    assert label_of(RecordingInfo(id="2"), label) is of_none


def test_without_a_contactor_or_item_it_is_the_material():
    cork = RecordingInfo(id="1", material="cork")
    assert (label_of(cork, "material+contactor"), item_of(cork)) == ("cork", "cork")
    with pytest.raises(ParameterError, match="label must be 'material', .* got 'speed'"):
        label_of(cork, "speed")
