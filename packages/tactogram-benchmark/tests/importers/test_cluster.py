"""Strokes of the cluster data set: its layouts, units and even times."""

import numpy as np
import openpyxl
import pandas
import pytest
from PIL import Image as Pillow
from scipy import signal as scipy_signal
from tests.datasets.importers.sample_files import imported, write_sound

from tactogram.errors import DataError
from tactogram_benchmark.importers import cluster


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
