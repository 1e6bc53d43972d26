"""What importers make of photographs: each with its material or its recording, and all of it or nothing."""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import openpyxl
import pytest
import soundfile
from hypothesis import given, strategies as st
from PIL import Image as Pillow

from tactogram.datasets import open_store
from tactogram.datasets.importers import cdplab, haptex
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.simulate import photo
from tactogram.datasets.simulate.photo import photographs
from tactogram.datasets.simulate.sets import SETS, STROKING_9
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram.workflows.data.stores import store_info


def write_photo(path, seed, *, rows=32, columns=48):
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), dtype=np.uint8)
    Pillow.fromarray(pixels).save(path, quality=95)


def write_sound(path, seed):
    path.parent.mkdir(parents=True, exist_ok=True)
    soundfile.write(path, np.random.default_rng(seed).uniform(-0.5, 0.5, 100), 1000, subtype="FLOAT")


def imported(name, source, tmp_path, **options):
    report = import_dataset(name, source, tmp_path / "store", workers=1, **options)
    return report, open_store(tmp_path / "store")


class TestLmt108:
    @pytest.fixture
    def source(self, tmp_path):
        source = tmp_path / "lmt"
        for n in (1, 2):
            for material in ("G1Mesh", "G4Bamboo"):
                write_sound(
                    source / "SoundScans" / f"{material}_Sound_Movement_train{n}.wav", [n, len(material)]
                )
        for n in (1, 2, 10):
            for kind in ("Flash", "NoFlash"):
                path = source / "ImageScans" / kind / "Training" / f"G4Bamboo_Image_1_train{n}.jpg"
                write_photo(path, [n, len(kind)])
        write_photo(source / "ImageScans" / "NoFlash" / "Testing" / "G4Bamboo_Image_1_test1.jpg", 99)
        return source

    def test_photographs_without_flash_belong_to_their_material(self, source, tmp_path):
        report, store = imported("lmt108", source, tmp_path)
        assert (report["recordings"], report["photographs"]) == (4, 4)
        sources = list(store.facts.photographs["G4Bamboo"].values())
        assert [name.rpartition("_")[2] for name in sources] == [
            "test1.jpg",
            "train1.jpg",
            "train2.jpg",
            "train10.jpg",
        ]
        assert not any("Flash/" in name.replace("NoFlash/", "") for name in sources)
        assert store.photographs_of("G1Mesh") == ()
        assert all(store.image(info.id) is None for info in store.index)
        assert problems(store) == []

    def test_importing_again_changes_nothing_unless_a_photograph_changed(self, source, tmp_path):
        imported("lmt108", source, tmp_path)
        report, _ = imported("lmt108", source, tmp_path)
        assert report["unchanged"]
        write_photo(source / "ImageScans" / "NoFlash" / "Training" / "G1Mesh_Image_1_train1.jpg", 7)
        with pytest.raises(
            DataError, match=r"holds something else than .*G1Mesh_Image_1_train1.jpg is another or new"
        ):
            imported("lmt108", source, tmp_path)

    def test_a_photograph_that_is_gone_is_noticed(self, source, tmp_path):
        imported("lmt108", source, tmp_path)
        (source / "ImageScans" / "NoFlash" / "Testing" / "G4Bamboo_Image_1_test1.jpg").unlink()
        with pytest.raises(DataError, match=r"3 photographs of materials here, 4 there"):
            imported("lmt108", source, tmp_path)

    def test_a_broken_photograph_is_named_and_leaves_nothing(self, source, tmp_path):
        broken = source / "ImageScans" / "NoFlash" / "Training" / "G4Bamboo_Image_1_train2.jpg"
        broken.write_bytes(broken.read_bytes()[:200])
        with pytest.raises(DataError, match=r"train2.jpg: not a readable picture: .*skip_bad"):
            imported("lmt108", source, tmp_path)
        assert [path for path in tmp_path.iterdir() if path != source] == []
        report, store = imported("lmt108", source, tmp_path, skip_bad=True)
        assert report["photographs"] == 3
        assert report["skipped"][0]["source"].endswith("train2.jpg")
        assert len(store.photographs_of("G4Bamboo")) == 3


def write_stroke(
    path, *, samples=4000, length=80.0, seed=0, heading="displacement [mm],friction coefficient\n"
):
    """Return the friction that is written: 0.5 and a pattern of 0.4 cycles per mm, at a speed that varies."""
    rng = np.random.default_rng(seed)
    place = np.cumsum(rng.uniform(0.2, 1.8, samples))
    place *= length / place[-1]
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = "".join(f"{d:.6f},{0.5 + 0.1 * np.sin(2 * np.pi * 0.4 * (d - place[0])):.6f}\n" for d in place)
    path.write_text(heading + rows)


class TestHapTex:
    def test_friction_is_over_displacement_on_a_registered_photograph(self, tmp_path):
        source = tmp_path / "haptex"
        write_stroke(source / "7" / "trial1.txt")
        write_photo(source / "7" / "photo.jpg", 7, rows=50, columns=50)
        report, store = imported("haptex", source, tmp_path)
        assert (report["recordings"], report["photographs"]) == (1, 1)
        [info] = store.index
        assert (info.material, info.contactor) == ("fabric007", "finger")
        signal = store.signal(info.id, "friction")
        assert (signal.domain, signal.unit, signal.axes) == ("displacement", "1", ("along",))
        assert signal.rate == haptex.RATE == pytest.approx(29.525)
        place = np.arange(len(signal)) / signal.rate
        inner = slice(60, -60)
        expected = 0.5 + 0.1 * np.sin(2 * np.pi * 0.4 * place)
        np.testing.assert_allclose(signal.samples[0][inner], expected[inner], atol=0.002)
        assert signal.length_mm == pytest.approx(80.0, abs=0.1)
        assert store.image(info.id).mm_per_pixel == 2.0
        assert any("registered" in line for line in info.history)

    @pytest.mark.parametrize(
        ("name", "heading", "columns"),
        [
            ("12.csv", "", 2),
            ("data/12.tsv", "Displacement (mm)\tFriction Coefficient\n", 2),
            ("Fabric12/1.txt", "", 5),
            ("x/12_3.txt", "displacement mu\n", 2),
        ],
    )
    def test_the_layouts_that_are_taken(self, tmp_path, name, heading, columns):
        path = tmp_path / "h" / name
        write_stroke(path, samples=500, heading="")
        rows = [line.split(",") for line in path.read_text().split()]
        separator = "\t" if name.endswith("tsv") else " "
        if columns == 5:
            rows = [("0.5", "1.0", mu, d, "30") for d, mu in rows]
        path.write_text(heading + "\n".join(separator.join(row) for row in rows))
        [item] = haptex.find(tmp_path / "h")
        [recording] = haptex.read(item)
        assert recording.material == "fabric012"
        assert recording.streams["friction"].samples.mean() == pytest.approx(0.5, abs=0.01)

    def test_metres_in_the_heading_are_metres(self, tmp_path):
        write_stroke(tmp_path / "1.csv", samples=500, length=0.08, heading="displacement [m],friction\n")
        [recording] = haptex.read(haptex.find(tmp_path)[0])
        assert recording.streams["friction"].length_mm == pytest.approx(80, abs=0.2)

    def test_several_photographs_and_fabrics_without_recordings_are_materials(self, tmp_path):
        source = tmp_path / "haptex"
        write_stroke(source / "1.txt", samples=400)
        for n, name in enumerate(("images/1_a.png", "images/1_b.png", "images/2.png")):
            write_photo(source / name, n)
        _, store = imported("haptex", source, tmp_path)
        assert [len(store.photographs_of(f"fabric00{n}")) for n in (1, 2)] == [2, 1]
        assert store.image(store.index[0].id) is None
        assert store_info(tmp_path / "store")["without_recordings"] == ["fabric002"]

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ("1,2,3\n2,3,4\n", r"must have 2 or 5 columns, got 3"),
            ("place,mu\n1,2\n2,3\n", "needs one column named like 'displacement'"),
            ("displacement,mu,cof\n1,2,3\n", "needs one column named like"),
            ("displacement,mu\n" + "1,0.5\n" * 50, r"must move over at least 16 samples, got 1"),
            ("displacement,mu\n1,x\n", "expected a number, got 'x'"),
            ("displacement,mu\n1,nan\n2,1\n", "must be finite"),
        ],
    )
    def test_what_is_no_stroke_is_said(self, tmp_path, text, says):
        (tmp_path / "h").mkdir()
        (tmp_path / "h" / "1.csv").write_text(text)
        with pytest.raises(DataError, match=says):
            imported("haptex", tmp_path / "h", tmp_path)

    @given(data=st.data())
    def test_what_goes_back_or_rests_is_left_out(self, data):
        steps = data.draw(st.lists(st.sampled_from([-0.3, 0.0, 0.2, 0.3]), min_size=150, max_size=300))
        place = np.concatenate([np.arange(50) * 0.2, 10 + np.cumsum(steps)])
        # Friction is what is felt where: a line over the place; going back must not bend it.
        if place[-1] <= 0:
            place = place[:50]
        signal, _ = haptex.friction_over(place, 0.1 + 0.01 * place, 5.0, "x")
        felt = signal.samples[0][20:-20]
        np.testing.assert_allclose(felt, 0.1 + 0.01 * (np.arange(len(signal)) / 5.0)[20:-20], atol=2e-3)

    def test_options_are_checked(self, tmp_path):
        write_stroke(tmp_path / "h" / "1.txt", samples=400)
        _, store = imported("haptex", tmp_path / "h", tmp_path, options={"rate": 10})
        assert store.rate(store.index[0].id, "friction") == 10
        with pytest.raises(ParameterError, match="rate must be a number > 0, got 'fast'"):
            import_dataset("haptex", tmp_path / "h", tmp_path / "t", options={"rate": "fast"})
        with pytest.raises(
            ParameterError, match="options of haptex must be among rate, width_mm, got 'speed'"
        ):
            import_dataset("haptex", tmp_path / "h", tmp_path / "t", options={"speed": 1})
        with pytest.raises(ParameterError, match="options of lmt108 must be among none"):
            import_dataset("lmt108", tmp_path / "h", tmp_path / "t", options={"speed": 1})


def write_book(path, *, samples=2000, speed=200.0, seed=0):
    rng = np.random.default_rng(seed)
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("Sheet1")
    sheet.append(["speed", "force", "accel", "friction"])
    for i in range(samples):
        felt = 0.4 + 0.1 * np.sin(2 * np.pi * 0.5 * i * speed / 1000)
        sheet.append([speed, 2.0 + 0.1 * rng.standard_normal(), rng.standard_normal(), felt])
    path.parent.mkdir(parents=True, exist_ok=True)
    book.save(path)


class TestCdpLab:
    @pytest.mark.parametrize("folders", [("xlsx", "images"), ("published/multidata", "published/image")])
    def test_guesses_are_said_and_friction_is_over_displacement(self, tmp_path, folders):
        source = tmp_path / "cdp"
        write_book(source / folders[0] / "wood.xlsx")
        write_photo(source / folders[1] / "wood.png", 0)
        _, store = imported("cdplab", source, tmp_path)
        [info] = store.index
        assert (info.material, info.speed_mm_s) == ("wood", 200.0)
        assert any("1000 Hz taken, none is stated" in line for line in info.history)
        assert store.streams["speed"].unit == "m/s"
        friction = store.signal(info.id, "friction")
        assert (friction.domain, friction.rate) == ("displacement", cdplab.PER_MM)
        assert friction.length_mm == pytest.approx(400, abs=1)
        place = np.arange(len(friction)) / friction.rate
        expected = 0.4 + 0.1 * np.sin(2 * np.pi * 0.5 * place)
        np.testing.assert_allclose(friction.samples[0][100:-100], expected[100:-100], atol=2e-3)
        assert store.image(info.id).size == (32, 48)

    def test_another_rate_and_unit_may_be_given(self, tmp_path):
        source = tmp_path / "cdp"
        write_book(source / "xlsx" / "wood.xlsx", speed=20.0)
        _, store = imported("cdplab", source, tmp_path, options={"rate": 500.0, "speed_unit": "cm/s"})
        friction = store.signal(store.index[0].id, "friction")
        assert friction.length_mm == pytest.approx(800, abs=1)
        with pytest.raises(ParameterError, match="speed_unit must be a unit of speed"):
            cdplab.find(source, speed_unit="N")

    @pytest.mark.real_data
    def test_real_files_come_with_their_photographs(self, real_data, tmp_path):
        item = next(i for i in cdplab.find(real_data("cdplab_friction")) if "copper" in i.name)
        [recording] = cdplab.read(item)
        over, time = recording.streams["friction"], recording.streams["friction_time"]
        assert len(time) == 18998
        assert over.length_mm == pytest.approx(18.998 * recording.speed_mm_s, rel=0.01)
        assert over.samples.mean() == pytest.approx(time.samples.mean(), abs=0.01)
        assert over.samples.min() > 0
        assert item.image.name == "copper.png"


class TestFolder:
    def test_a_picture_called_like_a_recording_is_its_own(self, tmp_path):
        source = tmp_path / "f"
        for n, name in enumerate(("cork/1.wav", "cork/2.wav")):
            write_sound(source / name, n)
        for n, name in enumerate(("cork/1.jpg", "cork/far.png")):
            write_photo(source / name, n, rows=10 + n)
        _, store = imported("folder", source, tmp_path)
        assert [store.image(info.id).size[0] for info in store.index] == [10, 11]
        assert store.facts.photographs == {}
        assert len(store.photographs_of("cork")) == 2

    def test_several_pictures_are_photographs_of_the_material(self, tmp_path):
        source = tmp_path / "f"
        write_sound(source / "cork" / "a.wav", 0)
        for n, name in enumerate(
            ("cork/p1.png", "cork/photos/p2.png", "felt/only.png", "top.png", "cork/.p3.png")
        ):
            write_photo(source / name, n)
        _, store = imported("folder", source, tmp_path)
        assert {m: len(held) for m, held in store.facts.photographs.items()} == {"cork": 2, "felt": 1}
        assert store.image(store.index[0].id) is None
        info = store_info(tmp_path / "store")
        assert info["photographs"] == {"cork": 2, "felt": 1}
        assert (info["images"], info["without_recordings"], info["without_photographs"]) == (3, ["felt"], [])

    def test_a_table_that_names_the_material_names_that_of_its_pictures(self, tmp_path):
        source = tmp_path / "f"
        write_sound(source / "day1" / "a.wav", 0)
        for n in range(3):
            write_photo(source / "day1" / f"p{n}.png", n)
        (source / "recordings.csv").write_text("file,material,image\nday1/a.wav,cork,day1/p0.png\n")
        _, store = imported("folder", source, tmp_path)
        assert len(store.facts.photographs["cork"]) == 2
        assert len(store.photographs_of("cork")) == 3

    def test_deep_and_turned_pictures_are_stored_as_they_are_seen(self, tmp_path):
        source = tmp_path / "f"
        write_sound(source / "cork" / "a.wav", 0)
        deep = np.linspace(0, 65535, 600).astype(np.uint16).reshape(20, 30)
        Pillow.fromarray(deep).save(source / "cork" / "deep.png")
        exif = Pillow.Exif()
        exif[0x0112] = 6
        Pillow.new("RGB", (30, 20), (9, 9, 9)).save(source / "cork" / "turned.jpg", exif=exif)
        _, store = imported("folder", source, tmp_path)
        by_source = {name: store.photograph(key) for key, name in store.facts.photographs["cork"].items()}
        assert by_source["cork/turned.jpg"].size == (30, 20)
        np.testing.assert_array_equal(by_source["cork/deep.png"].pixels[..., 0], np.round(deep / 257))
        assert problems(store) == []


@pytest.mark.real_data
def test_photographs_of_biotac_slide_are_one_per_material(real_data):
    from tactogram.datasets.importers import biotac_slide

    items = biotac_slide.find(real_data("biotac_slide"))
    assert len({item.image for item in items}) == 15
    assert all(item.image.is_file() for item in items)


class TestSimulated:
    def test_places_do_not_overlap_and_have_a_scale(self, monkeypatch):
        monkeypatch.setattr(photo, "render", cache(photo.render))  # the same ground each time
        images = list(photographs(STROKING_9[0], 9))
        assert all(image.mm_per_pixel == pytest.approx(0.15) for image in images)
        assert {image.size for image in images} == {(224, 224)}
        assert len({image.pixels.tobytes() for image in images}) == 9
        few = list(photographs(STROKING_9[0], 4))
        assert [image.size for image in few] == [(336, 336)] * 4  # larger, of the same ground
        np.testing.assert_array_equal(few[3].pixels[-224:, -224:], images[8].pixels)
        (one,) = photographs(STROKING_9[0], 1)
        assert one.size == (672, 672)
        assert list(photographs(STROKING_9[0], 0)) == []
        with pytest.raises(ParameterError, match="room for 0 to 9 photographs, got 10"):
            list(photographs(STROKING_9[0], 10))

    def test_a_store_of_several_photographs_each(self, tmp_path, monkeypatch):
        few = replace(SETS["stroking9"], surfaces=STROKING_9[:1])
        monkeypatch.setitem(SETS, "stroking9", few)
        common = {"seed": 0, "per_class": 1, "seconds": 0.2, "workers": 1}
        with pytest.raises(ParameterError, match="room for"):
            simulate_to_store("stroking9", tmp_path / "no", photographs=10, **common)
        assert list(tmp_path.iterdir()) == []
        report = simulate_to_store("stroking9", tmp_path / "s", photographs=2, **common)
        assert (report["recordings"], report["photographs"]) == (1, 2)
        store = open_store(tmp_path / "s")
        assert {len(keys) for keys in store.photographs_by_material.values()} == {2}
        assert all(store.image(info.id) is None for info in store.index)
        assert "--photographs 2" in store.facts.source


KILLED_AT_EACH_STEP = """
import os, sys
from pathlib import Path
import pandas  # by pyarrow on its first use: here once, not in each child
import pyarrow.parquet as pq
from tactogram.datasets.importer import importers
from tactogram.datasets.importing import import_dataset

source, folder = Path(sys.argv[1]), Path(sys.argv[2])
importers()

def work(step):
    out = folder / f"step{step}" / "s"
    out.parent.mkdir()
    left = step

    def killing(real):
        def call(*args, **options):
            nonlocal left
            left -= 1
            if left == 0:
                os.kill(os.getpid(), 9)
            return real(*args, **options)
        return call

    for name in ("replace", "unlink", "write_text", "mkdir", "rename"):
        setattr(Path, name, killing(getattr(Path, name)))
    for name in ("write_table", "close"):
        setattr(pq.ParquetWriter, name, killing(getattr(pq.ParquetWriter, name)))
    import_dataset("folder", source, out, workers=1)

for step in range(1, 200):
    child = os.fork()
    if child == 0:
        work(step)
        os._exit(0)
    if os.waitpid(child, 0)[1] == 0:
        break
"""


def test_killed_at_any_step_there_is_nothing_or_all_photographs(tmp_path):
    source = tmp_path / "source"
    write_sound(source / "cork" / "a.wav", 0)
    for n in range(3):
        write_photo(source / "cork" / f"p{n}.png", n)
    subprocess.run([sys.executable, "-c", KILLED_AT_EACH_STEP, source, tmp_path], check=True)
    found = []
    for folder in sorted(tmp_path.glob("step*"), key=lambda p: int(p.name[4:])):
        if (folder / "s").exists():
            store = open_store(folder / "s")
            assert problems(store) == []
            found.append(len(store.photographs_of("cork")))
        else:
            found.append(0)
            assert all(name.startswith("s.part-") for name in os.listdir(folder))
    assert len(found) > 6
    assert set(found) == {0, 3}
    assert found == sorted(found)
