"""Friction of HapTex over displacement, and its photographs."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from tests.datasets.importers.sample_files import imported_alone, write_photo

from tactogram.datasets.importing import import_dataset
from tactogram.errors import DataError, ParameterError
from tactogram.workflows.data.stores import store_info
from tactogram_benchmark.importers import haptex


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
        """Cai et al. 2020, Sec. 4: "the relationships between the frictional coefficients and the displacements"."""
        source = tmp_path / "haptex"
        write_stroke(source / "7" / "trial1.txt")
        write_photo(source / "7" / "photo.jpg", 7, rows=50, columns=50)
        report, store = imported_alone("haptex", source, tmp_path)
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
        _, store = imported_alone("haptex", source, tmp_path)
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
            imported_alone("haptex", tmp_path / "h", tmp_path)

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
        _, store = imported_alone("haptex", tmp_path / "h", tmp_path, options={"rate": 10})
        assert store.rate(store.index[0].id, "friction") == 10
        with pytest.raises(ParameterError, match="rate must be a number > 0, got 'fast'"):
            import_dataset("haptex", tmp_path / "h", tmp_path / "t", options={"rate": "fast"})
        with pytest.raises(
            ParameterError, match="options of haptex must be one of rate, width_mm, got 'speed'"
        ):
            import_dataset("haptex", tmp_path / "h", tmp_path / "t", options={"speed": 1})
        with pytest.raises(ParameterError, match="options of biotac_slide must be one of none"):
            import_dataset("biotac_slide", tmp_path / "h", tmp_path / "t", options={"speed": 1})
