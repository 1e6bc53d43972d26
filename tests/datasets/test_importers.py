"""What each importer reads: layouts as their sources describe them, and the real files where they are at hand."""

import csv

import numpy as np
import openpyxl
import pandas
import pytest
import soundfile
from PIL import Image as Pillow
from scipy import signal as scipy_signal

from tactogram.cli import main
from tactogram.datasets import Ratings, add_ratings, item_of, open_store
from tactogram.datasets.importers import biotac_slide, cluster, folder, vibviz
from tactogram.datasets.importing import import_dataset
from tactogram.errors import DataError, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal


def write_sound(path, seed, *, rate=44100, seconds=0.02, channels=1, subtype="PCM_16"):
    path.parent.mkdir(parents=True, exist_ok=True)
    samples = np.random.default_rng(seed).uniform(-0.5, 0.5, (round(rate * seconds), channels))
    soundfile.write(path, samples, rate, subtype=subtype)
    return soundfile.read(path, dtype="float32", always_2d=True)[0].T


def write_lines(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{v:.6f}\n" for v in values))


def imported(name, source, tmp_path, **options):
    report = import_dataset(name, source, tmp_path / "store", **options)
    return report, open_store(tmp_path / "store")


class TestLmt108:
    def test_files_are_told_by_their_names(self, tmp_path):
        source = tmp_path / "lmt"
        rng = np.random.default_rng(0)
        written = {}
        for n in (1, 2, 10):
            write_sound(source / "SoundScans" / f"G1Mesh_Sound_Movement_train{n}.wav", n)
            for axis in "XYZ":
                written[n, axis] = rng.standard_normal(50).round(6)
                write_lines(source / "AccelScans" / f"G1Mesh_Movement_{axis}_train{n}.txt", written[n, axis])
        write_lines(source / "AccelScans" / "G1Mesh_DFT321_Movement_train1.txt.old", [0.0])
        _, store = imported("lmt108", source, tmp_path)
        assert [i.labels["recording"] for i in store.index] == ["1", "2", "10"]
        info = store.index[2]
        assert (info.material, info.labels["group"], info.labels["part"]) == ("G1Mesh", "G1", "train")
        acceleration = store.signal(info.id, "acceleration")
        assert (acceleration.rate, acceleration.unit, acceleration.axes) == (
            10_000.0,
            "m/s^2",
            ("x", "y", "z"),
        )
        np.testing.assert_allclose(acceleration.axis("y"), written[10, "Y"], rtol=1e-6)
        assert store.signal(info.id, "sound").rate == 44100
        assert any("the files do not say" in line for line in info.history)

    @pytest.mark.parametrize(
        ("files", "says"),
        [
            ({"readme.txt": "x"}, "must hold files named like G1Material"),
            ({f"G1A_Movement_{a}_test1.txt": "1\n" for a in "XY"}, r"Movement_Z_test1.txt: missing"),
            (
                {f"G1A_Movement_{a}_test1.txt": "1\n" * n for a, n in (("X", 2), ("Y", 2), ("Z", 3))},
                "equally long, got .*_X_test1.txt 2,",
            ),
            (
                {f"G1A_Movement_{a}_test1.txt": "1\n\nx y\n" for a in "XYZ"},
                "X_test1.txt: row 3, column 1: must be a finite number, got 'x y'",
            ),
            (
                {f"{d}/G1A_Movement_{a}_test1.txt": "1\n" for a in "XYZ" for d in "ab"},
                "a second X of G1A, recording test1; keep one",
            ),
        ],
    )
    def test_what_is_wrong_is_said(self, tmp_path, files, says):
        for name, text in files.items():
            (tmp_path / "lmt" / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / "lmt" / name).write_text(text)
        with pytest.raises(DataError, match=says):
            imported("lmt108", tmp_path / "lmt", tmp_path)
        assert not (tmp_path / "store").exists()

    @pytest.mark.real_data
    def test_real_recordings(self, real_data, tmp_path):
        source = real_data("lmt108_sound")
        report, store = imported("lmt108", source, tmp_path)
        with (source / "index.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert report["recordings"] == len(rows) == 160
        assert len({i.material for i in store.index}) == 20
        found = {info.source: info for info in store.index}
        for row in rows:
            info = found[row["file"]]
            assert (info.material, info.labels["recording"]) == (row["material"], row["recording"])
            assert store.length(info.id, "sound") == int(row["samples"])
        expected = soundfile.read(source / rows[77]["file"], dtype="float32")[0]
        sound = store.signal(found[rows[77]["file"]].id, "sound")
        np.testing.assert_array_equal(sound.samples[0], expected)


def write_stroke(source, stem, *, seconds=0.5, jitter=0.15, seed=0, kinds=("accel", "force", "position")):
    """Write the files of one stroke as dataset_details.md describes them; return what was sampled."""
    rng = np.random.default_rng(seed)
    even = np.arange(round(6000 * seconds)) / 6000
    times = 0.000999 + even + rng.uniform(-jitter, jitter, len(even)) / 6000
    frequencies = (80.0, 210.0, 700.0)
    g = np.stack([0.3 * np.sin(2 * np.pi * f * (times - times[0])) for f in frequencies])
    force = 0.5 + 0.05 * np.sin(2 * np.pi * 20 * (times - times[0]))
    tables = {
        "accel": ("time,X,Y,Z", [times, *g]),
        "force": ("time,force", [times, force]),
        "position": (
            "time,X,Y",
            [np.arange(round(100 * seconds)) / 100] + 2 * [np.arange(round(100 * seconds)) * 0.4],
        ),
    }
    for kind in kinds:
        path = source / "sensor_data" / kind / f"{stem}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        head, columns = tables[kind]
        np.savetxt(path, np.transpose(columns), "%.9f", ",", header=head, comments="")
    return frequencies


class TestCluster:
    def test_a_stroke_is_read_to_si_units_at_even_times(self, tmp_path):
        source = tmp_path / "texture_dataset"
        frequencies = write_stroke(source, "0_135_40_500_0")
        write_sound(source / "sensor_data" / "audio" / "0_135_40_500_0.wav", 3)
        images = source / "images" / "images_scan_area"
        images.mkdir(parents=True)
        Pillow.new("RGB", (50, 40), (9, 9, 9)).save(images / "img0.jpg")
        _, store = imported("cluster", source, tmp_path)

        [info] = store.index
        known = (info.speed_mm_s, info.force_n, info.direction_deg, info.material)
        assert known == (40.0, 0.5, 135.0, "texture 0")
        assert info.labels == {"texture": "0", "repeat": "0"}
        assert store.image(info.id).mm_per_pixel == 2.0
        assert set(store.streams_of(info.id)) == {"acceleration", "force", "position", "sound"}
        acceleration = store.signal(info.id, "acceleration")
        assert (acceleration.rate, acceleration.unit) == (6000.0, "m/s^2")
        t = np.arange(len(acceleration)) / 6000
        for axis, frequency in zip("xyz", frequencies, strict=True):
            expected = 0.3 * 9.80665 * np.sin(2 * np.pi * frequency * t)
            error = (acceleration.axis(axis) - expected)[100:-100]
            assert np.sqrt((error**2).mean()) < 1e-2 * 0.3 * 9.80665
        force = store.signal(info.id, "force")
        assert (force.unit, force.axes) == ("N", ("z",))
        assert np.mean(force.samples) == pytest.approx(0.5, abs=1e-3)
        position = store.signal(info.id, "position")
        assert (position.unit, position.rate, position.axes) == ("m", 100.0, ("x", "y"))
        assert np.diff(position.samples[0]).mean() * 100 == pytest.approx(0.04, rel=1e-2)
        assert "acceleration: stamps show 6000." in info.history[0]

    def test_resampling_does_what_nearest_index_does_not(self, tmp_path):
        write_stroke(tmp_path, "0_0_20_500_0", jitter=0.3)
        [recording] = cluster.read(cluster.find(tmp_path)[0])
        raw = np.loadtxt(tmp_path / "sensor_data" / "accel" / "0_0_20_500_0.csv", delimiter=",", skiprows=1)
        ours, nearest = (
            self.noise(x) for x in (recording.streams["acceleration"].axis("z"), raw[:, 3] * 9.80665)
        )
        assert ours < nearest / 30

    @staticmethod
    def noise(x):
        """Return the share of the power that is not near the tone of 700 Hz."""
        frequencies, power = scipy_signal.periodogram(x[200:-200], 6000, window="blackmanharris")
        return power[np.abs(frequencies - 700) > 20].sum() / power.sum()

    def test_layouts_names_and_order(self, tmp_path):
        source = tmp_path / "cluster"
        for texture in ("10", "2"):
            for stem in (f"{texture}_0_20_500_0", f"{texture}_315_60_1000_1"):
                write_stroke(source / "texture_dataset", stem, seconds=0.05, seed=hash(stem) % 2**32)
        root = source / "texture_dataset"
        for kind in ("accel", "force", "position"):
            (root / "sensor_data" / kind / "2").mkdir()
            for path in (root / "sensor_data" / kind).glob("2_*"):
                path.rename(path.parent / "2" / path.name)
        book = openpyxl.Workbook()
        for row in (["No.", "Texture name", "friction"], [2, "felt", 0.3], [10, "felt", 0.4], [3, "cork", 1]):
            book.active.append(row)
        book.save(root / "texture_list.xlsx")
        _, store = imported("cluster", source, tmp_path)
        assert [i.labels["texture"] for i in store.index] == ["2", "2", "10", "10"]
        assert {i.material for i in store.index} == {"felt (2)", "felt (10)"}
        assert store.index[1].source == "texture_dataset/sensor_data/accel/2/2_315_60_1000_1.csv"

    def test_the_copy_in_parquet_and_flac_is_read(self, tmp_path):
        write_stroke(tmp_path, "0_0_20_500_0", seconds=0.05)
        [before] = cluster.read(cluster.find(tmp_path)[0])
        for path in (tmp_path / "sensor_data").rglob("*.csv"):
            pandas.read_csv(path).to_parquet(path.with_suffix(".parquet"))
            path.unlink()
        write_sound(tmp_path / "sensor_data" / "audio" / "0_0_20_500_0.flac", 3)
        [recording] = cluster.read(cluster.find(tmp_path)[0])
        assert set(recording.streams) == {*before.streams, "sound"}
        for name, signal in before.streams.items():
            np.testing.assert_array_equal(recording.streams[name].samples, signal.samples)

    def test_streams_that_are_not_there_at_all_are_left_out(self, tmp_path):
        write_stroke(tmp_path / "c", "0_0_20_500_0", kinds=("force",), seconds=0.05)
        [recording] = cluster.read(cluster.find(tmp_path / "c")[0])
        assert set(recording.streams) == {"force"}

    @pytest.mark.parametrize(
        ("name", "text", "says"),
        [
            ("accel/0_0_20_500_1.csv", "time,X,Y,Z\n0,1,2,3\n", r"force/0_0_20_500_1.csv: missing"),
            ("accel/readme.csv", "x\n", "name must be TEXTURE_DIRECTION|force/readme.csv: missing"),
            (
                "force/0_0_20_500_0.csv",
                "time,X\n0,1\n0.1,1\n",
                "needs columns time,force, lacks force, has time,X",
            ),
            (
                "force/0_0_20_500_0.csv",
                "time,force\n0,1\n0.1,x\n",
                "row 3, column force: must be a finite number",
            ),
            (
                "force/0_0_20_500_0.csv",
                "time,force\n0,1\n0.1\n0.2,3\n",
                "row 3, column force: must be a finite",
            ),
            (
                "force/0_0_20_500_0.csv",
                "time,force\n0,1\n0.1,nan\n",
                "row 3, column force: must be a finite number, got 'nan'",
            ),
            ("force/0_0_20_500_0.csv", "time,force\n0,1\n", "must have 2 or more rows"),
            ("force/0_0_20_500_0.csv", "time,force\n0,1\n0.2,1\n0.1,1\n", "time goes backwards"),
        ],
    )
    def test_what_is_wrong_is_said(self, tmp_path, name, text, says):
        source = tmp_path / "c"
        write_stroke(source, "0_0_20_500_0", seconds=0.05)
        (source / "sensor_data" / name).write_text(text)
        with pytest.raises(DataError, match=says) as caught:
            imported("cluster", source, tmp_path)
        assert "\n" not in str(caught.value)
        assert not (tmp_path / "store").exists()


class TestBiotacSlide:
    HEAD = ",".join(
        ["timestamp", "tdc", "tac", "pdc"]
        + [f"pac{i}" for i in range(1, 23)]
        + [f"ele{i}" for i in range(1, 20)]
    )

    @pytest.mark.parametrize("folder", ["raw_csv", "raw_data/mat2"])  # the second one as published
    def test_raw_tables_are_read_where_there_are_no_arrays(self, tmp_path, folder):
        frames = np.arange(3 * 44).reshape(3, 44)
        rows = "".join(f"{i / 100},{','.join(map(str, row))},\n" for i, row in enumerate(frames))
        (tmp_path / folder).mkdir(parents=True)
        for name in ("mat2_10_bio.csv", "mat2_9_bio.csv", "mat2_9_jv.csv"):
            (tmp_path / folder / name).write_text(f"{self.HEAD}\n{rows}")
        items = biotac_slide.find(tmp_path)
        assert [item.name for item in items] == [f"{folder}/mat2_9_bio.csv", f"{folder}/mat2_10_bio.csv"]
        [recording] = biotac_slide.read(items[1])
        assert recording.labels["recording"] == "10"
        np.testing.assert_array_equal(recording.streams["pac"].samples[0], frames[:, 3:25].reshape(-1))
        np.testing.assert_array_equal(recording.streams["electrodes"].axis("e19"), frames[:, 43])
        assert recording.streams["pdc"].rate == 100
        assert any("the sign is lost" in line for line in recording.history)

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ("timestamp,pac1\n0,1\n", "needs columns tdc,tac,pdc,pac1,pac2,pac3,…, lacks tdc,tac,pdc,pac2"),
            (HEAD + "\n", "must have 1 or more rows of samples"),
            (HEAD + "\n1,2\n", "row 2, column tac: must be a finite number"),
            (HEAD + "\n" + ",".join(["x"] * 45) + "\n", "row 2, column tdc: must be a finite number"),
        ],
    )
    def test_what_is_wrong_is_said(self, tmp_path, text, says):
        path = tmp_path / "b" / "mat1_1_bio.csv"
        path.parent.mkdir()
        path.write_text(text)
        with pytest.raises(DataError, match=says):
            imported("biotac_slide", tmp_path / "b", tmp_path)

    @pytest.mark.real_data
    def test_real_recordings(self, real_data, tmp_path):
        report, store = imported("biotac_slide", real_data("biotac_slide"), tmp_path)
        assert report["recordings"] == 600
        lengths = {}
        for info in store.index:
            lengths.setdefault(info.material, []).append(store.length(info.id, "pac") / 2200)
        assert len(lengths) == 15
        assert lengths.pop("Carpet net") == pytest.approx([6.0] * 40, abs=0.05)
        assert [s for held in lengths.values() for s in held] == pytest.approx([8.0] * 560, abs=0.05)
        assert len(store.photograph_keys()) == 15

    @pytest.mark.real_data
    def test_real_tables_and_arrays_give_the_same_recordings(self, real_data):
        source = real_data("biotac_slide")
        ids = {r.id for item in biotac_slide.find(source) for r in biotac_slide.read(item)}
        raw = [biotac_slide.read(item)[0].id for item in biotac_slide.find(source / "raw_csv")]
        assert len(raw) == 30
        assert set(raw) <= ids


class TestVibviz:
    HEAD = "id,index,energy,tempo,roughness,pleasantness,arousal,sensationTags\n"

    def test_effects_have_ratings(self, tmp_path):
        source = tmp_path / "v"
        mono = write_sound(source / "wav" / "v-1.wav", 1, rate=8000)
        stereo = write_sound(source / "wav" / "v-2.wav", 2, rate=48000, channels=2)
        (source / "vibrationAnnotations-2016.csv").write_text(
            self.HEAD + 'v-1,11,-2,0.5,-2.6,0.7,-2.5,"simple,soft"\nv-2,12,1,2,3,-3,0,\nv-3,13,0,0,0,0,0,\n'
        )
        _, store = imported("vibviz", source, tmp_path)
        one, two = store.index
        assert one.material is None
        assert one.ratings == {
            "energy": -2,
            "tempo": 0.5,
            "roughness": -2.6,
            "pleasantness": 0.7,
            "arousal": -2.5,
        }
        assert one.labels == {"effect": "v-1", "item": "v-1", "sensationTags": "simple,soft"}
        np.testing.assert_allclose(store.signal(one.id, "vibration").samples, mono)
        assert store.rate(two.id, "vibration") == 48000
        np.testing.assert_allclose(store.signal(two.id, "vibration").samples, stereo)
        assert store.signal(two.id, "vibration").axes == ("left", "right")

    def test_means_are_the_ratings_of_one_rater_of_the_effects_that_have_a_file(self, tmp_path):
        write_sound(tmp_path / "v" / "v-1.wav", 1, rate=8000)
        table = tmp_path / "v" / "vibrationAnnotations.csv"
        table.write_text(self.HEAD + "v-1,11,-2,0.5,-2.6,0.7,-2.5,\nv-3,13,0,0,0,0,0,\n")
        report, store = imported("vibviz", tmp_path / "v", tmp_path)
        assert report["scores"] == 5
        assert (store.ratings.items, store.ratings.raters) == (("v-1",), ("mean",))
        assert store.ratings.words == vibviz.RATINGS
        np.testing.assert_array_equal(store.ratings.means, [[-2, 0.5, -2.6, 0.7, -2.5]])
        assert import_dataset("vibviz", tmp_path / "v", tmp_path / "store")["unchanged"]
        table.write_text(self.HEAD + "v-1,11,-2,0.5,-2.6,0.7,-9,\n")
        with pytest.raises(DataError, match="score must be -3 to 3, got -9"):
            import_dataset("vibviz", tmp_path / "v", tmp_path / "store")

    @pytest.mark.parametrize(
        ("rows", "says"),
        [
            ("v-2,1,1,1,1,1,1,\n", r"wav/v-1.wav: has no row in"),
            ("v-1,1,x,1,1,1,1,\n", "energy must be a number, got 'x'"),
        ],
    )
    def test_what_is_wrong_is_said(self, tmp_path, rows, says):
        write_sound(tmp_path / "v" / "wav" / "v-1.wav", 1)
        (tmp_path / "v" / "vibrationAnnotations.csv").write_text(self.HEAD + rows)
        with pytest.raises(DataError, match=says):
            imported("vibviz", tmp_path / "v", tmp_path)

    @pytest.mark.real_data
    def test_real_recordings(self, real_data, tmp_path):
        report, store = imported("vibviz", real_data("vibviz"), tmp_path)
        assert report["recordings"] == 100
        rates = {store.rate(i.id, "vibration") for i in store.index}
        assert rates == {8000, 22050, 44100, 48000}
        assert all(set(i.ratings) == set(vibviz.RATINGS) for i in store.index)
        assert all(-3 <= v <= 3 for i in store.index for v in i.ratings.values())
        ratings = store.ratings
        assert (len(ratings.items), ratings.raters, len(ratings)) == (100, ("mean",), 500)
        assert not np.isnan(ratings.cube).any()
        for info in store.index:
            scored = dict(
                zip(ratings.words, ratings.means[ratings.items.index(info.labels["item"])], strict=True)
            )
            assert scored == dict(info.ratings)


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
            ("file,image\ncork/a.wav,photo.png\n", r"photo.png: not readable"),
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
            (tmp_path / "f" / "cork" / f"take{n}.tdms").write_bytes(b"x")
        words = ["data", "import", "folder", str(tmp_path / "f")]
        assert main([*words, "--preview"]) == main([*words, "--out", str(tmp_path / "s")]) == int(stops)
        assert (tmp_path / "s").exists() != stops
        said = capsys.readouterr()
        first = "2 files: suffix" if stops else "cork/take0.tdms: suffix"
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
