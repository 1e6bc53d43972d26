import json

import numpy as np
import pytest

from tactogram.rendering.files.catalogue import haptic_formats
from tactogram.rendering.files.reading import check_file
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.workflows.rendering.render import render
from tactogram_studio.signals.pictures import card_height
from tactogram_studio.workspace.shelf import ResultArchive


@pytest.fixture(scope="module", name="kept")
def kept_fixture(workspace):
    """Give a kept, simulated result of 4 s."""
    noise = np.random.default_rng(0).standard_normal((3, 4000)).astype(np.float32)
    shelf = ResultArchive(workspace / "studio" / "kept")
    return shelf.keep(Signal(noise, 1000, "m/s^2", ("x", "y", "z")), title="Cork", facts={"simulated": True})


def drawn(tab):
    """Wait until the signal's pictures stand, in the room that was kept for them: nothing below has moved."""
    signal = tab.get_by_label("The signal")
    signal.locator(".spectrogram").wait_for()
    assert signal.locator(".pictures").bounding_box()["height"] == pytest.approx(
        card_height(3, small=True), abs=2
    )


def saved(tab, link, folder):
    """Download what a link leads to."""
    with tab.expect_download() as download:
        tab.get_by_role("link", name=link, exact=True).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def test_a_kept_result_becomes_a_drive_that_plays_and_stops(tab, kept, workspace, tmp_path):
    tab.goto(f"/send?of=kept:{kept.id}")
    drawn(tab)
    tab.get_by_label("The signal").get_by_text("simulated", exact=True).wait_for()
    tab.get_by_role("button", name="Fit to the display").click()
    report = tab.get_by_role("region", name="Fit report")
    report.get_by_role("img").wait_for()
    assert report.get_by_role("img").evaluate("image => image.decode().then(() => image.naturalWidth)") > 1000
    assert "not measured on a device" in report.get_by_role("note", name="Safety").inner_text()
    assert "0.5 of the limit of 5 V" in report.inner_text()

    drive = saved(tab, "Drive as WAV", tmp_path)
    expected = render(kept.file, tmp_path / "expected.wav", display="voice-coil", level="peak=0.5")
    assert drive.name == "drive.wav"
    assert np.array_equal(read_signal(drive).samples, read_signal(tmp_path / "expected.wav").samples)
    told = json.loads(saved(tab, "Report (JSON)", tmp_path).read_text())
    assert told["scaled"] == expected["report"]["scaled"]

    playing = tab.get_by_role("region", name="Play on a device")
    playing.get_by_role("button", name="Play").click()
    playing.get_by_text("of 4.0 s").wait_for()
    playing.get_by_role("button", name="Stop").click()
    playing.get_by_text("Cork: stopped after").wait_for()
    [line] = (workspace / "studio" / "played.jsonl").read_text().splitlines()
    facts = json.loads(line)
    assert (facts["device"], facts["strength"], facts["state"]) == ("null", 0.25, "stopped")

    tab.reload()
    tab.get_by_role("region", name="Fit report").get_by_role("img").wait_for()


def test_a_kept_result_becomes_every_file(tab, kept, tmp_path):
    tab.goto(f"/send?of=kept:{kept.id}")
    drawn(tab)
    tab.get_by_role("tab", name="To a haptic file").click()
    tab.get_by_role("button", name="Write and check").click()
    files = tab.get_by_role("region", name="Files")
    files.get_by_role("table").wait_for()
    for name, kind in haptic_formats().items():
        link = f"Cork-{name}{kind.suffix}" if kind.suffix == ".json" else f"Cork{kind.suffix}"
        assert check_file(saved(tab, link, tmp_path), format=name)["valid"]
    files.locator("canvas").wait_for()


def test_an_upload_is_sent_and_a_wrong_one_is_a_sentence(tab, tmp_path):
    write_signal(tmp_path / "mine.csv", Signal(np.ones((1, 500), np.float32), 500, "N", ("x",)))
    (tmp_path / "wrong.csv").write_text("no,signal\n")
    tab.goto("/send")
    tab.get_by_role("button", name="Upload a file").click()
    chooser = tab.locator("input[type=file]")
    chooser.set_input_files(tmp_path / "wrong.csv")
    tab.get_by_role("alert").get_by_text("wrong.csv").wait_for()
    chooser.set_input_files(tmp_path / "mine.csv")
    tab.get_by_label("The signal").get_by_text("mine.csv").wait_for()


def test_a_result_belongs_to_its_signal_and_tabs_keep_theirs(tab, kept, workspace, tmp_path):
    write_signal(workspace / "felt.csv", Signal(np.ones((1, 800), np.float32), 800, "m/s^2", ("x",)))
    felt = "/send?of=file:felt.csv"
    report = tab.get_by_role("region", name="Fit report")
    tab.goto(f"/send?of=kept:{kept.id}")
    drawn(tab)
    tab.get_by_role("button", name="Fit to the display").click()
    report.get_by_text("Cork on").wait_for()
    tab.get_by_role("button", name="Play", exact=True).click()
    tab.get_by_role("combobox", name="From").click()
    tab.get_by_role("option", name="Files: outputs of runs").click()
    tab.get_by_role("combobox", name="File", exact=True).click()
    tab.get_by_role("option", name="felt.csv").click()
    tab.get_by_label("The signal").get_by_text("felt.csv").wait_for()
    report.get_by_text("The fit report will appear here.").wait_for()
    assert tab.get_by_role("link", name="Drive as WAV").count() == 0
    # What still plays says what it is, and can be stopped.
    playing = tab.get_by_role("region", name="Playing on a device")
    playing.get_by_text("Cork: ").wait_for()
    playing.get_by_role("button", name="Stop").click()
    playing.wait_for(state="hidden")

    tab.wait_for_url(f"**{felt}*")
    other = tab.context.new_page()
    other.goto(f"/send?of=kept:{kept.id}")
    other.get_by_role("region", name="Fit report").get_by_text("Cork on").wait_for()  # its own again
    tab.reload()
    tab.get_by_label("The signal").get_by_text("felt.csv").wait_for()
    report.get_by_text("The fit report will appear here.").wait_for()
    other.close()


def test_what_cannot_be_felt_says_so_where_it_is_played(tab, workspace, tmp_path):
    t = np.arange(2000) / 1000
    quiet = Signal(1e-4 * np.sin(2 * np.pi * 200 * t)[None], 1000, "m/s^2", ("x",))
    write_signal(workspace / "quiet.npz", quiet)
    tab.goto("/send?of=file:quiet.npz&tab=display")
    signal = tab.get_by_label("The signal")
    note = signal.get_by_role("alert")
    note.get_by_text("Cannot be felt: its strongest moment is").wait_for()
    red = "e => getComputedStyle(e).color"
    assert note.evaluate(red) == "rgb(164, 38, 44)"
    assert signal.get_by_text("cannot be felt", exact=True).evaluate(red) == "rgb(164, 38, 44)"
    assert signal.locator(".scale").inner_text().split() == ["-150", "-80", "dB", "re", "1", "m/s²"]
    with tab.expect_download() as heard:
        tab.get_by_role("button", name="For listening (WAV)").click()
    heard.value.save_as(tmp_path / "heard.wav")
    assert heard.value.suggested_filename == "quiet-listening.wav"
    assert np.abs(read_signal(tmp_path / "heard.wav").samples).max() == pytest.approx(0.5, rel=0.01)

    tab.get_by_role("radio", name="Physical").click()
    tab.get_by_role("button", name="Fit to the display").click()
    report = tab.get_by_role("region", name="Fit report")
    report.get_by_role("alert").get_by_text("Cannot be felt: the output of this drive").wait_for()
    playing = tab.get_by_role("region", name="Play on a device")
    playing.get_by_role("alert").get_by_text("Cannot be felt: the output at this strength").wait_for()


def test_a_result_gives_nothing_but_its_own_files(tab):
    for path in ("20260101-000000-000000/drive.wav", "x/..%2F..%2Fsecret"):
        answer = tab.request.get(f"/send/result/{path}")
        assert answer.status == 404
        assert answer.headers["content-type"].split(";")[0] in ("text/plain", "text/html")  # no file
