import numpy as np
import pytest
from nicegui import Client, ui

from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram.workflows.data.stores import add_signal
from tactogram.workflows.recognition.spectral_search import band_centres, find_similar, spectrum
from tactogram_studio.pages.materials.media import draw_recordings, starts_of

SET = "studio/first/surfaces"


def tone(hz, *, rate=1000.0, seconds=1.0, level=1.0):
    t = np.arange(int(rate * seconds)) / rate
    return Signal(level * np.sin(2 * np.pi * hz * t) + 9.81, rate, "m/s^2")


@pytest.fixture
def tones(tmp_path):
    made = (
        Recording(
            streams={"acceleration": tone(hz, rate=rate)},
            material=f"tone-{hz}",
            speed_mm_s=float(hz),
            session=f"day {number % 2}",
            source=f"tones/{number}.wav",
        )
        for number, (hz, rate) in enumerate([(50, 1000.0), (100, 1000.0), (200, 1000.0), (100, 2000.0)])
    )
    return create_store(tmp_path / "tones", made, name="tones", licence="made in a test")


def test_the_starts_of_recordings_are_shown_on_one_scale(tones):
    starts = starts_of(tones, tones.index)
    assert set(starts) == {info.id for info in tones.index}
    with Client(ui.page("/starts-test")) as client:
        draw_recordings("tones", tones, tones.index, starts)
        texts = [element.text for element in client.elements.values() if isinstance(element, ui.label)]
        pictures = [str(element.props.get("src")) for element in client.elements.values()]
    assert "0 dB re 1 m/s²" in texts
    assert len([address for address in pictures if "spectrogram" in address and "top_db=0" in address]) == 4
    assert "Cannot be felt." not in texts
    client.delete()


def test_a_recording_that_cannot_be_felt_says_so_in_its_row(tmp_path):
    quiet = [Recording(streams={"acceleration": tone(100, level=1e-4)}, material="quiet", source="q.wav")]
    store = create_store(tmp_path / "quiet", quiet, name="quiet", licence="made in a test")
    with Client(ui.page("/unfelt-test")) as client:
        draw_recordings("quiet", store, store.index, starts_of(store, store.index))
        texts = [element.text for element in client.elements.values() if isinstance(element, ui.label)]
    assert "Cannot be felt." in texts
    client.delete()


def test_similar_recordings_have_the_same_spectrum_at_any_level_and_rate(tones, tmp_path):
    found = find_similar(tones, tone(100, level=0.1), count=2, cache=tmp_path / "spectra")
    assert [each["material"] for each in found["nearest"]] == ["tone-100", "tone-100"]
    assert found["nearest"][0]["distance"] < 2.0 < found["materials"][1]["distance"]
    assert "not a classifier" in found["measure"]
    assert len(list((tmp_path / "spectra").glob("*.npz"))) == 1
    again = find_similar(tones, tone(100, level=0.1), count=2, cache=tmp_path / "spectra")
    assert again == found
    without = find_similar(tones, tone(100), count=1, without=[each["id"] for each in found["nearest"]])
    assert without["nearest"][0]["material"] != "tone-100"
    over_mm = Signal(np.ones(100), 10.0, "1", domain="displacement")
    with pytest.raises(ParameterError, match="runs over time, the signal over displacement"):
        find_similar(tones, over_mm)


def test_a_spectrum_peaks_in_the_band_of_a_tone():
    levels, middles = spectrum(tone(100)), band_centres(1000.0, "time")
    assert middles[levels.argmax()] == pytest.approx(100, rel=0.12)
    assert levels.mean() == pytest.approx(0, abs=1e-4)
    assert spectrum(Signal(np.zeros(500), 1000.0, "m/s^2")).max() == 0


def test_an_addition_is_reported(tones, tmp_path):
    write_signal(tmp_path / "a.csv", tone(70), metadata={"simulated": True})
    write_image(tmp_path / "a.png", Image(np.zeros((8, 8, 3), np.uint8)))
    known = {"material": "x", "contactor": "pen", "photograph": tmp_path / "a.png", "force_n": 0.5}
    report = add_signal(tones.path, tmp_path / "a.csv", **known)
    assert (report["added"], report["mixed"], report["simulated"], report["recordings"]) == (
        True,
        True,
        True,
        5,
    )
    assert report["sha256_before"] == tones.sha256 != report["sha256"]
    store = open_store(tones.path)
    info = store.info(report["id"])
    assert (info.contactor, info.force_n, store.image(info.id).size) == ("pen", 0.5, (8, 8))
    assert add_signal(tones.path, tmp_path / "a.csv", **known)["added"] is False


def test_a_file_that_cannot_be_read_replaces_the_analysis_of_the_one_before(tab, tmp_path):
    write_signal(tmp_path / "good.csv", tone(70))
    (tmp_path / "bad.csv").write_text("no,numbers\nhere,at all\n")
    tab.goto("/materials/drop")
    tab.locator("input[type=file]").first.set_input_files(tmp_path / "good.csv")
    tab.get_by_role("heading", name="good.csv").first.wait_for()
    tab.locator("canvas").nth(1).wait_for()
    tab.locator("input[type=file]").first.set_input_files(tmp_path / "bad.csv")
    tab.get_by_role("alert").get_by_text("bad.csv: no rows of numbers").wait_for()
    assert tab.get_by_role("heading", name="good.csv").count() == 0
    tab.reload()
    tab.get_by_role("heading", name="Upload a recording").wait_for()
    assert tab.get_by_role("heading", name="good.csv").count() == 0


def test_an_uploaded_recording_is_compared_and_added(tab, workspace, tmp_path):
    store = open_store(workspace / SET)
    info = store.index[0]
    write_signal(tmp_path / "mine.csv", store.signal(info.id, "acceleration").cut(100, 900))
    bare = store.signal(info.id, "acceleration").samples[:, 100:900].T
    np.savetxt(tmp_path / "bare.csv", bare, delimiter=",", header="x,y,z", comments="")
    tab.goto("/materials")
    tab.get_by_role("link", name=SET).click()
    tab.get_by_role("heading", name="Materials (9)").wait_for()
    tab.get_by_role("link", name="carpet").first.click()
    tab.get_by_text("1 to 2 of 2").wait_for()
    tab.get_by_role("button", name="Upload a recording").click()
    tab.wait_for_url("**/drop**")
    chooser = tab.locator("input[type=file]").first
    (tmp_path / "bad.wav").write_bytes(b"MZ nothing")
    chooser.set_input_files(tmp_path / "bad.wav")
    tab.get_by_text("content does not match the suffix").wait_for()
    tab.goto(f"/materials/drop?set={SET}")
    tab.locator("input[type=file]").first.set_input_files(tmp_path / "bare.csv")
    tab.get_by_role("alert").filter(has_text="rate").wait_for()  # missing from the file: the page asks
    tab.get_by_label("Rate, Hz").fill("1000")
    tab.get_by_label("Unit", exact=True).fill("m/s^2")
    tab.get_by_role("button", name="Read again").click()
    similar = tab.get_by_label("Similar recordings")
    similar.get_by_text("not a classifier").wait_for()
    assert similar.locator(".recording").first.get_by_role("link").inner_text() == info.material
    add = tab.get_by_role("button", name="Add", exact=True)
    add.click()
    tab.get_by_text("Material: enter the material").wait_for()
    tab.get_by_label("Material", exact=True).fill("my desk")
    tab.get_by_label("Force, N").fill("0.4")
    add.click()
    tab.get_by_text("tick the box above").wait_for()  # measured into simulated
    tab.reload()  # the entries survive
    tab.get_by_role("checkbox", name="Mix measured and simulated").click()
    add.click()
    tab.get_by_text("now has 19 recordings").wait_for()
    added = [each for each in open_store(workspace / SET).index if each.material == "my desk"]
    assert [(each.force_n, each.simulated) for each in added] == [(0.4, False)]
    tab.get_by_role("link", name="Show the recording").click()
    tab.get_by_role("heading", name="my desk", exact=True).wait_for()
    tab.get_by_label("Similar recordings").locator(".recording").first.wait_for()
