"""A plain folder of recordings: names, table, options and photographs."""

import numpy as np
import pytest
from PIL import Image as Pillow
from tests.datasets.importers.sample_files import (
    imported,
    imported_alone,
    write_noise,
    write_photo,
    write_sound,
)

from tactogram.cli import main
from tactogram.datasets import Ratings, add_ratings, item_of, open_store
from tactogram.datasets.importers import folder
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.data.stores import store_info


class TestFolder:
    def test_what_was_rated_in_its_own_right_is_of_no_material(self, tmp_path):
        source = tmp_path / "f"
        self.write(source, "plate01/m01.wav", 1)
        self.write(source, "signals/signal01.wav", 2)
        self.write(source, "signals/more/x.wav", 3)
        (source / "recordings.csv").write_text(
            "file,item,session,stream\nsignals/more/x.wav,signal02,,drive\nplate01/m01.wav,,plate01-m01,strain\n"
        )
        (source / "images").mkdir()
        for n in (1, 2):
            Pillow.new("RGB", (3, 2), (n, 2, 3)).save(source / "images" / f"image{n}.png")
        _, store = imported("folder", source, tmp_path, options={"items": "signals,images"})
        assert sorted((item_of(i), i.material or "") for i in store.index) == [
            ("plate01", "plate01"),
            ("signal01", ""),
            ("signal02", ""),
        ]
        assert sorted(store.photographs_by_material) == ["image1", "image2"]
        assert set(store.streams) == {"strain", "drive", "vibration"}

    def test_ratings_that_were_added_do_not_make_it_another_import(self, tmp_path):
        self.write(tmp_path / "f", "cork/1.wav")
        _, store = imported("folder", tmp_path / "f", tmp_path)
        rated = add_ratings(store, Ratings(("r",), ("cork",), ("rough",), np.array([2.0])))
        assert imported("folder", tmp_path / "f", tmp_path)[0]["unchanged"]
        assert open_store(store.path).sha256 == rated.sha256

    def test_images_alone_make_a_store(self, tmp_path):
        (tmp_path / "f" / "images").mkdir(parents=True)
        for n in (1, 2):
            Pillow.new("RGB", (3, 2), (n, 2, 3)).save(tmp_path / "f" / "images" / f"image{n}.png")
        report, store = imported("folder", tmp_path / "f", tmp_path, options={"items": "images"})
        assert (report["recordings"], report["photographs"]) == (0, 2)
        assert sorted(store.photographs_by_material) == ["image1", "image2"]

    def test_a_folder_of_items_must_be_there(self, tmp_path):
        self.write(tmp_path / "f", "cork/1.wav")
        with pytest.raises(DataError, match="f/signal: must be a folder of rated files"):
            imported("folder", tmp_path / "f", tmp_path, options={"items": "signal"})

    def write(self, source, name, seed=0, **options):
        return write_sound(source / name, seed, rate=1000, seconds=0.1, subtype="FLOAT", **options)

    def test_the_folder_names_the_material(self, tmp_path):
        source = tmp_path / "f"
        for n, name in enumerate(("cork/2.wav", "cork/10.wav", "jeans/day1/a.wav")):
            self.write(source, name, n)
        self.write(source, "cork/.hidden.wav", 9)
        (source / "cork" / "notes.txt").write_text("x")
        Pillow.new("RGB", (3, 2), (1, 2, 3)).save(source / "cork" / "photo.png")
        _, store = imported("folder", source, tmp_path)
        assert [(i.material, i.source) for i in store.index] == [
            ("cork", "cork/2.wav"),
            ("cork", "cork/10.wav"),
            ("jeans", "jeans/day1/a.wav"),
        ]
        assert store.image(store.index[0].id).pixels.shape == (2, 3, 3)
        assert store.image(store.index[2].id) is None

    def test_the_table_says_the_rest(self, tmp_path):
        source = tmp_path / "f"
        samples = self.write(source, "a.wav", 1)
        self.write(source, "cork/b.wav", 2)
        Pillow.new("RGB", (20, 2), (1, 2, 3)).save(source / "photo.png")
        (source / "recordings.csv").write_text(
            "file,material,speed_mm_s,force_n,direction_deg,contactor,session,subject,image,image_width_mm,unit,"
            "stream,rating_rough,humidity\n"
            "a.wav,jeans,100,0.5,90,pen,monday,s1,photo.png,10,V,tap,6.5,40 %\n"
        )
        _, store = imported("folder", source, tmp_path)
        info = store.index[0]
        assert (info.material, info.speed_mm_s, info.force_n, info.direction_deg) == (
            "jeans",
            100.0,
            0.5,
            90.0,
        )
        assert (info.contactor, info.session, info.subject) == ("pen", "monday", "s1")
        assert (info.ratings, info.labels) == ({"rough": 6.5}, {"humidity": "40 %"})
        assert store.image(info.id).mm_per_pixel == 0.5
        signal = store.signal(info.id, "tap")
        assert (signal.unit, signal.rate) == ("V", 1000.0)
        np.testing.assert_array_equal(signal.samples, samples)

    @pytest.mark.parametrize(
        ("table", "says"),
        [
            ("name\nx\n", "needs columns file, lacks file, has name"),
            ("file,force_n\ncork/a.wav,fast\n", "row 2: force_n must be a number, got 'fast'"),
            ("file,force_n\ncork/a.wav,-3\n", "row 2: force_n must be at least 0, got -3"),
            ("file,force_n\ncork/b.wav,1\n", r"row 2: there is no signal file cork/b.wav"),
            ("file,force_n\ncork/a.wav,1\ncork/a.wav,1\n", r"row 3: cork/a.wav is also in row 2"),
            ("file\ncork/a.wav,1\n", "row 2 has more values than there are columns"),
            ("file,force_n\n,1\n", "row 2 names no file"),
            ("file,image\ncork/a.wav,photo.png\n", r"photo.png: no such file"),
        ],
    )
    def test_what_is_wrong_in_the_table_is_said(self, tmp_path, table, says):
        self.write(tmp_path / "f", "cork/a.wav")
        (tmp_path / "f" / "recordings.csv").write_text(table)
        with pytest.raises(DataError, match=says):
            imported("folder", tmp_path / "f", tmp_path)

    def test_options_say_of_every_file_what_none_says(self, tmp_path):
        (tmp_path / "f" / "cork").mkdir(parents=True)
        for name in "ab":
            rows = "".join(f"{n % 3},{n % 4},{n % 5}\n" for n in range(5 + ord(name)))
            (tmp_path / "f" / "cork" / f"{name}.csv").write_text(rows)
        (tmp_path / "f" / "recordings.csv").write_text("file,rate\ncork/b.csv,500\n")
        with pytest.raises(DataError, match=r"cork/a.csv: .* give the rate in Hz, e.g. `rate=1000`"):
            imported("folder", tmp_path / "f", tmp_path)
        options = {"rate": 330, "unit": "g", "axes": "x,y,z", "stream": "tap"}
        assert folder.find(tmp_path / "f", axes=5)[0].info["axes"] == ("5",)
        _, store = imported("folder", tmp_path / "f", tmp_path, options=options)
        [a, b] = (store.signal(info.id, "tap") for info in store.index)
        assert ((a.rate, b.rate), a.unit, a.axes) == ((330.0, 500.0), "m/s^2", ("x", "y", "z"))
        np.testing.assert_allclose(a.samples[:, 2], np.array([2, 2, 2]) * 9.80665, rtol=1e-6)

    @pytest.mark.parametrize(
        ("options", "says"),
        [
            ({"rate": "often"}, "rate must be a number > 0, got 'often'"),
            ({"rate": -5}, "rate must be a number > 0, got -5"),
            ({"unit": "furlong"}, "unit must be one of"),
            ({"unit": 0}, "unit must be one of"),
        ],
    )
    def test_options_that_say_nothing_are_refused(self, tmp_path, options, says):
        self.write(tmp_path / "f", "cork/a.wav")
        with pytest.raises(TactogramError, match=says):
            imported("folder", tmp_path / "f", tmp_path, options=options)

    def test_a_file_without_a_material_is_refused(self, tmp_path):
        self.write(tmp_path / "f", "a.wav")
        with pytest.raises(DataError, match="no folder names the material; state it with recordings.csv"):
            imported("folder", tmp_path / "f", tmp_path)
        self.write(tmp_path / "f", "cork/b.wav", 1)
        with pytest.raises(DataError, match=r"a.wav: must be in a folder named after its material"):
            imported("folder", tmp_path / "f", tmp_path)

    def test_text_tables_are_read_and_notes_are_reported(self, tmp_path):
        for n in range(3):
            self.write(tmp_path / "f", f"cork/{n}.wav", n)
        rows = "".join(f"{k / 100:.2f} {k % 7}\n" for k in range(30))
        (tmp_path / "f" / "cork" / "log.txt").write_text("t [s] force [N]\n" + rows)
        (tmp_path / "f" / "cork" / "notes.txt").write_text("Stroked 3 times\n1. slowly\n2. fast, at 1.5 N\n")
        (tmp_path / "f" / "cork" / "setup.pdf").write_text("x")
        (tmp_path / "f" / "cork" / "0.dat").write_text("the original of 0.wav")
        report, store = imported("folder", tmp_path / "f", tmp_path)
        assert [info.source for info in store.index][3] == "cork/log.txt"
        assert report["skipped"] == [
            {"source": "cork/notes.txt", "reason": "cork/notes.txt: not a table of numbers"}
        ]

    def test_metadata_of_phones_is_no_recording(self, tmp_path):
        folder = tmp_path / "f" / "cork" / "2026-05-04"
        (folder / "meta").mkdir(parents=True)
        rows = "".join(f"{k / 100},{k % 7}\n" for k in range(30))
        (folder / "Raw Data.csv").write_text('"Time (s)","Linear Acceleration x (m/s^2)"\n' + rows)
        for name in ("meta/device.csv", "meta/time.csv", "Metadata.csv"):
            (folder / name).write_text('"property","value"\n"model","a phone"\n')
        report, store = imported("folder", tmp_path / "f", tmp_path)
        assert ([info.material for info in store.index], report["skipped"]) == (["cork"], [])

    @pytest.mark.parametrize(("others", "stops"), [(1, False), (2, True)])
    def test_a_third_of_unknown_files_stops_the_import(self, tmp_path, capsys, others, stops):
        for n in range(4):
            self.write(tmp_path / "f", f"cork/{n}.wav", n)
        for n in range(others):
            (tmp_path / "f" / "cork" / f"take{n}.bdf").write_bytes(b"x")
        words = ["data", "import", "folder", str(tmp_path / "f")]
        assert main([*words, "--preview"]) == main([*words, "--out", str(tmp_path / "s")]) == int(stops)
        assert (tmp_path / "s").exists() != stops
        said = capsys.readouterr()
        first = "2 files: suffix" if stops else "cork/take0.bdf: suffix"
        assert f"skipped: {first} must be one of .wav" in said.out
        assert ("in all 2 of 6 files cannot be read: " in said.err) == stops
        assert main([*words, "--out", str(tmp_path / "s"), "--skip-bad"]) == 0

    def test_a_text_file_called_wav_is_named(self, tmp_path):
        (tmp_path / "f" / "cork").mkdir(parents=True)
        (tmp_path / "f" / "cork" / "a.wav").write_text("no sound at all")
        with pytest.raises(DataError, match=r"cork/a\.wav"):
            imported("folder", tmp_path / "f", tmp_path)

    def test_simulated_is_told_by_the_file_or_by_the_table(self, tmp_path):
        source = tmp_path / "f"
        for n in range(3):
            self.write(source, f"cork/{n}.wav", n)
        signal = Signal(np.random.default_rng(7).standard_normal(50), 1000.0, "1")
        for n, said in ((3, True), (4, "true"), (5, "false")):
            write_signal(
                source / "cork" / f"{n}.wav",
                signal.with_samples(n * signal.samples),
                metadata={"simulated": said},
            )
        (source / "recordings.csv").write_text("file,simulated\ncork/0.wav,yes\ncork/1.wav,no\n")
        _, store = imported("folder", source, tmp_path)
        assert [i.simulated for i in store.index] == [True, False, False, True, True, False]
        assert store.simulated

    def test_jitter_is_told(self, tmp_path):
        rng = np.random.default_rng(0)
        times = (np.arange(2000) + rng.uniform(-0.2, 0.2, 2000)) / 1000
        (tmp_path / "f" / "cork").mkdir(parents=True)
        rows = "".join(f"{t:.9f},{np.sin(300 * t):.6f}\n" for t in times)
        (tmp_path / "f" / "cork" / "a.csv").write_text("time,z\n" + rows)
        (tmp_path / "f" / "recordings.csv").write_text("file,unit,rate\ncork/a.csv,V,1000\n")
        _, store = imported("folder", tmp_path / "f", tmp_path)
        assert store.rate(store.index[0].id, "voltage") == 1000.0
        assert "jitter 11" in store.index[0].history[0]

    def test_what_is_exported_comes_back(self, tmp_path):
        signal = Signal(np.random.default_rng(0).standard_normal((3, 200)), 1000.0, "m/s^2")
        (tmp_path / "f" / "cork").mkdir(parents=True)
        for name in ("a.csv", "b.npz", "c.wav"):
            write_signal(tmp_path / "f" / "cork" / name, signal)
        for item in folder.find(tmp_path / "f"):
            [recording] = folder.read(item)
            np.testing.assert_allclose(recording.streams["acceleration"].samples, signal.samples, rtol=1e-5)


class TestFolderPhotographs:
    def test_a_picture_called_like_a_recording_is_its_own(self, tmp_path):
        source = tmp_path / "f"
        for n, name in enumerate(("cork/1.wav", "cork/2.wav")):
            write_noise(source / name, n)
        for n, name in enumerate(("cork/1.jpg", "cork/far.png")):
            write_photo(source / name, n, rows=10 + n)
        _, store = imported_alone("folder", source, tmp_path)
        assert [store.image(info.id).size[0] for info in store.index] == [10, 11]
        assert store.facts.photographs == {}
        assert len(store.photographs_of("cork")) == 2

    def test_several_pictures_are_photographs_of_the_material(self, tmp_path):
        source = tmp_path / "f"
        write_noise(source / "cork" / "a.wav", 0)
        for n, name in enumerate(
            ("cork/p1.png", "cork/photos/p2.png", "felt/only.png", "top.png", "cork/.p3.png")
        ):
            write_photo(source / name, n)
        _, store = imported_alone("folder", source, tmp_path)
        assert {m: len(held) for m, held in store.facts.photographs.items()} == {"cork": 2, "felt": 1}
        assert store.image(store.index[0].id) is None
        info = store_info(tmp_path / "store")
        assert info["photographs"] == {"cork": 2, "felt": 1}
        assert (info["images"], info["without_recordings"], info["without_photographs"]) == (3, ["felt"], [])

    def test_a_table_that_names_the_material_names_that_of_its_pictures(self, tmp_path):
        source = tmp_path / "f"
        write_noise(source / "day1" / "a.wav", 0)
        for n in range(3):
            write_photo(source / "day1" / f"p{n}.png", n)
        (source / "recordings.csv").write_text("file,material,image\nday1/a.wav,cork,day1/p0.png\n")
        _, store = imported_alone("folder", source, tmp_path)
        assert len(store.facts.photographs["cork"]) == 2
        assert len(store.photographs_of("cork")) == 3

    def test_deep_and_turned_pictures_are_stored_as_they_are_seen(self, tmp_path):
        source = tmp_path / "f"
        write_noise(source / "cork" / "a.wav", 0)
        deep = np.linspace(0, 65535, 600).astype(np.uint16).reshape(20, 30)
        Pillow.fromarray(deep).save(source / "cork" / "deep.png")
        exif = Pillow.Exif()
        exif[0x0112] = 6
        Pillow.new("RGB", (30, 20), (9, 9, 9)).save(source / "cork" / "turned.jpg", exif=exif)
        _, store = imported_alone("folder", source, tmp_path)
        by_source = {name: store.photograph(key) for key, name in store.facts.photographs["cork"].items()}
        assert by_source["cork/turned.jpg"].size == (30, 20)
        np.testing.assert_array_equal(by_source["cork/deep.png"].pixels[..., 0], np.round(deep / 257))
        assert problems(store) == []
