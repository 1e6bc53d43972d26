"""Signals that pages show: worked out once, and never in the event loop."""

import asyncio
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from nicegui import Client, ui

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram_studio.signals import registry as holding, view
from tactogram_studio.signals.registry import ShownSignals, key_of
from tactogram_studio.signals.traits import traits_of


def tone(amplitude, *, rate=1000.0, unit="m/s^2"):
    t = np.arange(1000) / rate
    return Signal(amplitude * np.sin(2 * np.pi * 50 * t)[None], rate, unit, ("a",))


def saved(path, signal):
    write_signal(path, signal)
    return path


def test_the_key_follows_from_samples_and_what_they_mean():
    signal = tone(0.1)

    assert key_of(signal) == key_of(tone(0.1))
    assert key_of(signal) != key_of(Signal(signal.samples, 1001.0, "m/s^2", ("a",)))
    assert key_of(signal) != key_of(Signal(signal.samples, 1000.0, "N", ("a",)))


def test_what_was_not_asked_for_longest_is_let_go():
    shown = ShownSignals()
    first, second = (shown.load(tone(a)).key for a in (0.1, 0.2))
    shown.signals.most = 2 * holding._bytes(shown.get(second))
    shown.get(first)

    third = shown.load(tone(0.3)).key

    assert len(shown.get(third).signal) == 1000
    with pytest.raises(DataError, match="reload"):
        shown.get(second)
    assert shown.get(first).traits.peak == pytest.approx(0.1, rel=1e-3)


def test_a_signal_is_worked_out_once_however_many_pages_ask(tmp_path, monkeypatch):
    file, asked, calls = saved(tmp_path / "a.npz", tone(0.1)), threading.Barrier(3), []
    monkeypatch.setattr(holding, "traits_of", lambda signal: calls.append(signal) or traits_of(signal))
    shown = ShownSignals()

    def ask(source):
        asked.wait()
        return shown.load(source).key

    with ThreadPoolExecutor(3) as pages:
        keys = set(pages.map(ask, [file, file, file]))

    assert keys == {key_of(tone(0.1))} == {shown.load(tone(0.1)).key}
    assert len(calls) == 1


def test_a_file_that_was_written_anew_is_read_anew(tmp_path):
    shown, file = ShownSignals(), saved(tmp_path / "a.npz", tone(0.1))
    assert shown.cached(file) is None
    shown.load(file)
    assert shown.cached(file).traits.peak == pytest.approx(0.1, rel=1e-3)

    os.utime(saved(file, tone(0.5)), ns=(1, 1))

    assert shown.cached(file) is None
    assert shown.load(file).traits.peak == pytest.approx(0.5, rel=1e-3)
    assert shown.cached(tmp_path / "nothing.npz") is None


@pytest.fixture
def page():
    """Give a page that nobody has opened."""
    client = Client(ui.page("/signals-test"))
    with client:
        yield client
    if client.id in Client.instances:
        client.delete()


def cards(entries):
    """Draw cards; return their places and what fills them."""
    places = [view._frame(entry)[1] for entry in entries]
    return places, view._fill_later(entries, places, same_gain=False, small=False)


def said(place):
    return [element.text for element in place.descendants() if isinstance(element, ui.label)]


def test_the_loop_goes_on_while_pictures_are_worked_out(page, tmp_path, monkeypatch):
    """Working out waits for the loop: in the loop it would wait for ever, here it is told so and fails."""
    monkeypatch.setattr(view, "SHOWN", ShownSignals())
    ticked = threading.Event()
    monkeypatch.setattr(holding, "traits_of", lambda signal: traits_of(signal) if ticked.wait(60) else None)
    places, fill = cards(
        [view.SignalEntry(saved(tmp_path / "a.npz", tone(0.1)), "A"), view.SignalEntry(tone(0.4), "B")]
    )

    async def drawn():
        filling = asyncio.create_task(fill)
        await asyncio.sleep(0)
        assert not filling.done()
        ticked.set()
        await filling

    asyncio.run(drawn())

    assert [said(place)[0][:10] for place in places] == ["0.0707 m/s", "0.283 m/s²"]
    charts = [[e for e in place.descendants() if isinstance(e, ui.echart)] for place in places]
    assert {chart[0].options["yAxis"][0]["max"] for chart in charts} == {0.5}  # on one scale
