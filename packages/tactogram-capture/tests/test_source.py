"""A tap on a source: its listener, and the source behind it."""

import numpy as np
import pytest

from tactogram_capture import open_source
from tactogram_capture.session.feed import Feed
from tactogram_capture.source import TappedSource


def test_each_block_is_passed_on_and_the_source_keeps_its_attributes():
    heard = []
    with TappedSource(
        open_source("simulated:twelite?rate=330&seconds=2"),
        lambda source, block: heard.append(block),
    ) as source:
        feed = Feed(source)
        read = [block for _ in range(5) if (block := feed.poll(0.5)) is not None]
        assert source.axes == ("x", "y", "z")
        assert source.facts()["simulated"]
    came = [block for block in heard if block is not None]
    assert all(np.array_equal(a.samples, b.samples, equal_nan=True) for a, b in zip(read, came, strict=True))


def test_an_exception_of_the_listener_ends_the_reading():
    def hears(source, block):
        raise KeyboardInterrupt

    with (
        TappedSource(open_source("simulated:twelite?rate=330&paced=false"), hears) as source,
        pytest.raises(KeyboardInterrupt),
    ):
        source.read(0.5)
