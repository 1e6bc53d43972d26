"""Takes of the laboratory of Saga et al., in files made to their description: jittered stamps in us, whole counts."""

import numpy as np
import pytest

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.errors import DataError

COUNTS = np.array([[350.0], [300.0], [410.0]])
"""Zero of the converter and gravity, per axis."""
HZ = (40.0, 70.0, 100.0)


def write_take(path, seed, *, samples=5400, queued=0):
    """Write a take of a sine of 30 counts per axis, rounded to counts, at stamps that jitter around 936 us.

    It may begin with queued samples, 60 us apart, after which as many are lost.
    """
    rng = np.random.default_rng(seed)
    stamps = np.round(2_000_000 + 936 * (np.arange(samples) + rng.uniform(-0.1, 0.1, samples)))
    x = COUNTS + 30 * np.sin(2e-6 * np.pi * np.outer(HZ, stamps - stamps[0]))
    stamps[:queued] = stamps[queued] - 60 * np.arange(queued, 0, -1)
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack([stamps, np.round(x).T, np.zeros((samples, 2))])
    np.savetxt(path, rows, fmt="%d", delimiter=",")


@pytest.fixture
def source(tmp_path):
    for seed, name in enumerate(("ArtGrass01_03", "ArtGrass01_14", "ArtGrass01_14(1)", "Luncheon02_3")):
        write_take(tmp_path / "set" / name.partition("_")[0] / f"{name}.csv", seed)
    return tmp_path / "set"


def test_takes_have_their_texture_number_and_level(source, tmp_path):
    report = import_dataset("saga_strokes", source, tmp_path / "store", workers=1)
    assert "no file of the set was at hand" in report["unverified"]
    store = open_store(tmp_path / "store")
    found = {(info.material, info.labels["recording"], info.labels["take"]) for info in store.index}
    grass = {("ArtGrass01", "3", "1"), ("ArtGrass01", "14", "1"), ("ArtGrass01", "14", "2")}
    assert found == grass | {("Luncheon02", "3", "1")}
    signal = store.signal(store.index[0].id, "acceleration")
    assert (signal.rate, signal.unit, signal.axes) == (1000, "m/s^2", ("x", "y", "z"))
    assert signal.seconds == pytest.approx(5400 * 936e-6, abs=2e-3)
    inside = signal.samples[:, 200:-200].astype(float)
    times = np.arange(len(signal))[200:-200] / 1000
    expected = 30 * np.sin(2 * np.pi * np.outer(HZ, times)) * 9.80665 / 60
    # Rounding to counts: 0.29 counts rms, less what lies beyond the band of the result.
    assert np.sqrt(np.mean((inside - expected) ** 2)) < 0.35 * 9.80665 / 60
    assert "stamps show 1068.4 Hz" in store.index[0].history[0]
    assert "60 counts per g, assumed" in store.index[0].history[1]


@pytest.mark.parametrize("queued", [0, 5, 64])
def test_samples_queued_before_the_log_are_left_out(tmp_path, queued):
    """A burst with stamps 60 us apart counted as samples of the take, with `0 samples lost`."""
    write_take(tmp_path / "set" / "Carpet01" / "Carpet01_01.csv", 0, queued=queued)
    import_dataset("saga_strokes", tmp_path / "set", tmp_path / "store", workers=1)
    [info] = (store := open_store(tmp_path / "store")).index
    assert store.signal(info.id, "acceleration").seconds == pytest.approx((5400 - queued) * 936e-6, abs=2e-3)
    assert "0 samples lost" in info.history[0]
    said = [line for line in info.history if "queued" in line]
    assert said == [f"the first {queued} samples, queued before the log began, left out"] * bool(queued)


def test_counts_per_g_is_an_option(source, tmp_path):
    for name, factor in (("a", 60.0), ("b", 120.0)):
        import_dataset("saga_strokes", source, tmp_path / name, workers=1, options={"counts_per_g": factor})
    first, second = (open_store(tmp_path / name) for name in "ab")
    one, other = (store.signal(store.index[0].id, "acceleration").samples for store in (first, second))
    np.testing.assert_allclose(one, 2 * other, rtol=1e-6)


def test_a_folder_without_takes_is_refused(tmp_path):
    (tmp_path / "takes.csv").write_text("0,1,2,3,0,0\n")
    with pytest.raises(DataError, match=r"must hold takes such as ArtGrass01/ArtGrass01_03.csv"):
        import_dataset("saga_strokes", tmp_path, tmp_path / "store", workers=1)
