"""Sound cards of a library that stands in for miniaudio: which there are, and what one plays."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from tactogram.errors import DeviceError
from tactogram_playback.sound_card import opened_card, sound_cards


class NoBackendError(Exception):
    pass


@pytest.fixture
def library(monkeypatch):
    """miniaudio with two cards and ALSA's null device; its devices record what they were opened with."""
    opened = []
    names = ("USB Audio", "Headphones", "Discard all samples (playback) or generate zero samples (capture)")

    class PlaybackDevice:
        backend = "ALSA"

        def __init__(self, **options):
            self.options, self.running, self.closed = options, None, False
            opened.append(self)

        def start(self, source):
            self.running = source

        def stop(self):
            self.running = None

        def close(self):
            self.closed = True

    made = SimpleNamespace(
        SampleFormat=SimpleNamespace(FLOAT32="float32"),
        Backend=SimpleNamespace(NULL="null"),
        MiniaudioError=NoBackendError,
        PlaybackDevice=PlaybackDevice,
        Devices=lambda: SimpleNamespace(
            backend="Backend.ALSA",
            get_playbacks=lambda: [{"name": name, "id": number} for number, name in enumerate(names)],
        ),
        opened=opened,
    )
    monkeypatch.setitem(sys.modules, "miniaudio", made)
    return made


def pull(count):
    return np.arange(2 * count, dtype=np.float32).reshape(count, 2)


def test_cards_are_listed_by_name_without_the_one_that_discards(library):
    assert sound_cards() == {"USB Audio": 0, "Headphones": 1}


def test_where_there_is_only_a_null_device_there_is_no_card(library):
    library.Devices = lambda: SimpleNamespace(
        backend="Backend.NULL", get_playbacks=lambda: [{"name": "x", "id": 0}]
    )
    assert sound_cards() == {}

    def none():
        raise NoBackendError("no backend")

    library.Devices = none
    assert sound_cards() == {}
    with (
        pytest.raises(DeviceError, match="no sound card found: plug one in, or play on the null device"),
        opened_card(pull, rate=8000, channels=2, buffer_ms=10, null=False),
    ):
        pass


def test_a_card_plays_the_frames_it_asks_for_and_is_closed(library):
    with opened_card(pull, rate=8000.0, channels=2, buffer_ms=0.2, null=False, name="Headphones") as card:
        assert card.backend == "ALSA"
        card.start()
        [device] = library.opened
        frames = np.frombuffer(device.running.send(3), np.float32)
        np.testing.assert_array_equal(frames, pull(3).ravel())
        card.stop()
        assert device.running is None
        assert not device.closed
    assert device.closed
    options = device.options
    assert (options["sample_rate"], options["nchannels"], options["buffersize_msec"]) == (8000, 2, 1)
    assert (options["device_id"], options["backends"]) == (1, None)


def test_the_null_device_needs_no_card(library):
    library.Devices = None
    with opened_card(pull, rate=8000, channels=1, buffer_ms=10, null=True):
        pass
    assert library.opened[0].options["backends"] == ["null"]


def test_an_unknown_card_lists_the_known_ones_and_a_failing_one_is_closed(library):
    with (
        pytest.raises(DeviceError, match="no sound card is called 'USB'; there are USB Audio, Headphones"),
        opened_card(pull, rate=8000, channels=1, buffer_ms=10, null=False, name="USB"),
    ):
        pass
    with (
        pytest.raises(DeviceError, match="^audio:USB Audio: unplugged$"),
        opened_card(pull, rate=8000, channels=1, buffer_ms=10, null=False, name="USB Audio"),
    ):
        raise RuntimeError("unplugged")
    assert library.opened[-1].closed
