"""FrictGAN's pairs in the layout that the authors' code opens: spectrograms become friction that has them."""

import numpy as np
import pytest
from frictgan_windows import amplitudes, friction_of, write_window

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.errors import DataError
from tactogram_benchmark.importers.frictgan import recovered


def test_friction_has_the_amplitudes_and_the_level(tmp_path):
    for part, fabric, number in (("train", 2, 200), ("train", 2, 201), ("test", 8, 100)):
        write_window(tmp_path / "dataset" / part / str(fabric), number, friction_of(number))
    report = import_dataset("frictgan", tmp_path / "dataset", tmp_path / "s", workers=1)
    store = open_store(tmp_path / "s")
    assert (report["photographs"], "assumed" in report["unverified"]) == (3, True)
    found = [(info.material, info.session, info.labels["part"]) for info in store.index]
    assert found == [("fabric008",) * 2 + ("test",), *[("fabric002",) * 2 + ("train",)] * 2]
    signal = store.signal(store.index[0].id, "friction")
    assert (signal.domain, signal.rate, len(signal)) == ("displacement", pytest.approx(29.525), 1280)
    assert store.image(store.index[0].id).mm_per_pixel == pytest.approx(100 / 2362)
    assert signal.samples.mean() == pytest.approx(0.4, rel=1e-2)
    target = amplitudes(friction_of(100))
    assert np.linalg.norm(amplitudes(signal.samples[0]) - target) < 0.01 * np.linalg.norm(target)


def test_a_scaled_spectrogram_is_scaled_friction():
    (one, error), (two, _) = recovered(amplitudes(friction_of(1))), recovered(2 * amplitudes(friction_of(1)))
    np.testing.assert_allclose(two, 2 * one, rtol=1e-4)
    assert error < 0.01


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 2 3\n" * 257, "must hold 257 x 11 amplitudes of at least 0, got 257 x 3"),
        ("1 2 3 4 5 6 7 8 9 10 -1\n" * 257, "the smallest -1"),
        ("1 2 x\n", "row 1, column 3: must be a finite number, got 'x'"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, says):
    folder = tmp_path / "d" / "train" / "2" / "output_data"
    folder.mkdir(parents=True)
    (folder / "1.txt").write_text(text)
    with pytest.raises(DataError, match=says):
        import_dataset("frictgan", tmp_path / "d", tmp_path / "s", workers=1)
