"""Tables and arrays of the BioTac slide recordings, and their photographs."""

import numpy as np
import pytest
from tests.datasets.importers.sample_files import imported

from tactogram.errors import DataError
from tactogram_benchmark.importers import biotac_slide


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


@pytest.mark.real_data
def test_photographs_of_biotac_slide_are_one_per_material(real_data):
    from tactogram_benchmark.importers import biotac_slide

    items = biotac_slide.find(real_data("biotac_slide"))
    assert len({item.image for item in items}) == 15
    assert all(item.image.is_file() for item in items)
