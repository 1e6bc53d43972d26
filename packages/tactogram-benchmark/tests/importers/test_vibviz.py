"""VibViz: effects, and the means of their ratings."""

import numpy as np
import pytest
from tests.datasets.importers.sample_files import imported, write_sound

from tactogram.datasets.importing import import_dataset
from tactogram.errors import DataError
from tactogram_benchmark.importers import vibviz


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
