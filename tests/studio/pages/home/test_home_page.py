import json
import signal
import sys
import urllib.error
import urllib.request

import pytest

from tactogram.datasets import open_store

ARGUMENTS = ("studio", "--port", "0", "--no-open", "--folder", ".")
PAGES = ("Make", "Touch", "Materials", "Train", "Send", "Live", "Studies", "Reports")


@pytest.fixture(scope="module")
def empty(tmp_path_factory):
    """Give a folder in which nothing is."""
    return tmp_path_factory.mktemp("empty")


@pytest.fixture(scope="module")
def running(empty, served):
    """Give the process and the address of a studio that was begun with nothing."""
    with served(*ARGUMENTS, folder=empty, prefix="studio: ") as found:
        yield found


@pytest.fixture(scope="module")
def server(running):
    """Give the address of a studio that was begun with nothing."""
    return running[1]


def test_an_empty_workspace_gets_something_to_play_with(tab, empty):
    tab.goto("/")
    tab.get_by_text("Making something to play with").wait_for()
    tab.get_by_role("button", name="Touch them").wait_for(timeout=120_000)
    voices = json.loads((empty / "studio/first/voices/data.json").read_text())
    assert voices["simulated"] is True
    speeds = {info.speed_mm_s for info in open_store(empty / "studio/first/surfaces").index}
    assert len(speeds) == 3  # what is felt can follow a hand


def test_every_page_is_reached_by_the_navigation_and_says_where_one_is(tab):
    tab.goto("/")
    for name in PAGES:
        tab.get_by_role("navigation", name="Pages").get_by_role("link", name=name, exact=True).click()
        tab.get_by_role("heading", level=1, name=name).wait_for()
        assert tab.locator("nav [aria-current=page]").all_inner_texts() == [name]


def test_the_content_is_one_key_away(tab):
    tab.goto("/")
    tab.keyboard.press("Tab")
    tab.keyboard.press("Enter")

    assert tab.evaluate("document.activeElement.id") == "content"


def test_on_a_tablet_nothing_is_wider_than_the_screen(tab):
    tab.set_viewport_size({"width": 820, "height": 1180})
    for name in ("", *(name.lower() for name in PAGES)):
        tab.goto(f"/{name}")
        tab.locator("h1").wait_for()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 820, name


def test_an_interrupted_start_is_taken_up_again(tmp_path):
    from tactogram.studio.workspace.starter_data import StarterData

    first = StarterData(tmp_path / "first")
    (first.store / "half").mkdir(parents=True)

    assert first.state == "absent"
    first._follow = lambda command: None
    first._make()
    assert not (first.store / "half").exists()


def test_why_the_first_surfaces_could_not_be_made_is_told(tmp_path):
    from tactogram.studio.workspace.starter_data import StarterData

    first = StarterData(tmp_path)
    first._follow([sys.executable, "-c", "print('learning'); raise SystemExit('no space is left')"])

    assert first.state == "failed"
    assert first.line == "the first surfaces could not be made: no space is left"


def test_an_unknown_page_is_told(server):
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"{server}/nothing", timeout=10)


def test_what_pages_hold_lies_in_the_workspaces_own_folder(tab, empty, until):
    tab.goto("/train")  # it keeps what its form holds
    tab.get_by_role("heading", level=1, name="Train").wait_for()
    until(lambda: list((empty / "studio/state").glob("storage-user-*.json")))  # it is written a moment later
    assert not list(empty.glob(".nicegui"))


def test_it_ends_when_it_is_interrupted(running):  # the last: the others need it
    process, _ = running
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 0
