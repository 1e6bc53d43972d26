import asyncio

import numpy as np
import pytest
from nicegui import Client, ui

from tactogram.signal import Signal
from tactogram_studio.signals import view


def tone(amplitude, *, rate=1000.0, unit="m/s^2"):
    t = np.arange(1000) / rate
    return Signal(amplitude * np.sin(2 * np.pi * 50 * t)[None], rate, unit, ("a",))


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


@pytest.mark.parametrize("left", ["page", "cards"])
def test_a_page_that_was_left_meanwhile_is_left_alone(page, left):
    with ui.element("div") as around:
        places, fill = cards([view.SignalEntry(tone(0.2), "A")])
    page.delete() if left == "page" else around.delete()

    asyncio.run(fill)

    assert said(places[0]) == []


def test_signals_of_other_units_are_on_scales_of_their_own(page):
    places, fill = cards([view.SignalEntry(tone(0.4), "A"), view.SignalEntry(tone(40.0, unit="N"), "B")])

    asyncio.run(fill)

    assert all("has its own scales" in said(place)[-1] for place in places)


def test_a_file_that_is_gone_is_told_in_its_card(page, tmp_path):
    places, fill = cards([view.SignalEntry(tmp_path / "gone.npz", "A")])

    asyncio.run(fill)

    assert said(places[0])[0].startswith("This signal cannot be shown: ")
