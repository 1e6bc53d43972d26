"""LMT108: files told by their names, and photographs of materials."""

import csv

import numpy as np
import pytest
import soundfile
from tests.datasets.importers.sample_files import (
    imported,
    imported_alone,
    write_noise,
    write_photo,
    write_sound,
)

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.store.store import problems
from tactogram.errors import DataError, ParameterError


def write_lines(path, values):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(f"{v:.6f}\n" for v in values))


class TestLmt108:
    def test_files_are_told_by_their_names(self, tmp_path):
        """Neshov et al. 2026, Sec. 4.1: "triaxial acceleration signals (X, Y, Z)", "sampled at 10 kHz"."""
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


class TestLmt108Photographs:
    @pytest.fixture
    def source(self, tmp_path):
        source = tmp_path / "lmt"
        for n in (1, 2):
            for material in ("G1Mesh", "G4Bamboo"):
                write_noise(
                    source / "SoundScans" / f"{material}_Sound_Movement_train{n}.wav", [n, len(material)]
                )
        for n in (1, 2, 10):
            for kind in ("Flash", "NoFlash"):
                path = source / "ImageScans" / kind / "Training" / f"G4Bamboo_Image_1_train{n}.jpg"
                write_photo(path, [n, len(kind)])
        write_photo(source / "ImageScans" / "NoFlash" / "Testing" / "G4Bamboo_Image_1_test1.jpg", 99)
        return source

    def test_photographs_without_flash_belong_to_their_material(self, source, tmp_path):
        """Neshov et al. 2026, Sec. 4.1: "only the non-flash variants of the images are considered"."""
        report, store = imported_alone("lmt108", source, tmp_path)
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

    def test_one_part_of_some_materials_is_imported_if_asked_for(self, source, tmp_path):
        """Neshov et al. 2026, Sec. 4.1: "the training portion of the dataset", nine of its materials."""
        write_noise(source / "SoundScans" / "G4Bamboo_Sound_Movement_test1.wav", [7])
        options = {"part": "train", "materials": "G4Bamboo"}
        import_dataset("lmt108", source, tmp_path / "bamboo", workers=1, options=options)
        store = open_store(tmp_path / "bamboo")
        assert [(info.material, info.labels["part"]) for info in store.index] == [("G4Bamboo", "train")] * 2
        assert len(store.photographs_of("G4Bamboo")) == 3
        for option, known in (("part", "test, train"), ("materials", "G1Mesh, G4Bamboo")):
            with pytest.raises(ParameterError, match=f"{option} must be one of {known}, got 'Oak'"):
                import_dataset("lmt108", source, tmp_path / "none", workers=1, options={option: "Oak"})

    def test_importing_again_changes_nothing_unless_a_photograph_changed(self, source, tmp_path):
        imported_alone("lmt108", source, tmp_path)
        report, _ = imported_alone("lmt108", source, tmp_path)
        assert report["unchanged"]
        write_photo(source / "ImageScans" / "NoFlash" / "Training" / "G1Mesh_Image_1_train1.jpg", 7)
        with pytest.raises(
            DataError, match=r"holds something else than .*G1Mesh_Image_1_train1.jpg is another or new"
        ):
            imported_alone("lmt108", source, tmp_path)

    def test_a_photograph_that_is_gone_is_noticed(self, source, tmp_path):
        imported_alone("lmt108", source, tmp_path)
        (source / "ImageScans" / "NoFlash" / "Testing" / "G4Bamboo_Image_1_test1.jpg").unlink()
        with pytest.raises(DataError, match=r"3 photographs of materials here, 4 there"):
            imported_alone("lmt108", source, tmp_path)

    def test_a_broken_photograph_is_named_and_leaves_nothing(self, source, tmp_path):
        broken = source / "ImageScans" / "NoFlash" / "Training" / "G4Bamboo_Image_1_train2.jpg"
        broken.write_bytes(broken.read_bytes()[:200])
        with pytest.raises(DataError, match=r"train2.jpg: not a readable picture: .*skip_bad"):
            imported_alone("lmt108", source, tmp_path)
        assert [path for path in tmp_path.iterdir() if path != source] == []
        report, store = imported_alone("lmt108", source, tmp_path, skip_bad=True)
        assert report["photographs"] == 3
        assert report["skipped"][0]["source"].endswith("train2.jpg")
        assert len(store.photographs_of("G4Bamboo")) == 3
