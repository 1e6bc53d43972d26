"""Friction of CDP Lab over displacement."""

import numpy as np
import openpyxl
import pytest
from tests.datasets.importers.sample_files import imported_alone, write_photo

from tactogram.errors import ParameterError
from tactogram_benchmark.importers import cdplab


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
        _, store = imported_alone("cdplab", source, tmp_path)
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
        _, store = imported_alone("cdplab", source, tmp_path, options={"rate": 500.0, "speed_unit": "cm/s"})
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
