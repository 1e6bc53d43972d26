"""The study of the ultrasonic display: files of the layout that its importer expects, written here."""

import csv

import numpy as np
import pytest

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import DataError
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.spectra import sensor_spectra
from tactogram_benchmark.importers import keio_ultrasonic

RATE = 2500.0


def table(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        csv.writer(file).writerows(rows)


@pytest.fixture
def study(tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(2500) / RATE
    folder = tmp_path / "study"
    table(folder / "plates" / "1" / "m01.csv", rng.standard_normal((6250, 4)))
    table(folder / "plates" / "12_m01.csv", np.abs(rng.standard_normal((3, 1000))))
    table(folder / "signals" / "1.csv", 2.0 * np.sin(2 * np.pi * 40 * time)[:, None])
    table(folder / "signals" / "2.csv", np.eye(1, 1000, 79))
    for name, items in (("plates", (1, 12)), ("signals", (1, 2))):
        rows = [(f"p{person}", item, *[1 + (person + item) % 7] * 10) for person in (1, 2) for item in items]
        table(folder / f"{name}.csv", [("rater", "item", *WORDS), *rows])
    return folder


def test_plates_signals_and_ratings_become_a_store_that_ultrasonic_cgan_learns_from(study, tmp_path):
    import_dataset(
        "keio_ultrasonic", study, tmp_path / "store", workers=1, options={"rate": RATE, "full_scale": 2.0}
    )
    store = open_store(tmp_path / "store")
    assert sorted(info.material for info in store.index if info.material) == ["plate01", "plate12"]
    assert store.ratings.items == ("plate01", "plate12", "signal01", "signal02")
    np.testing.assert_allclose(store.ratings.rated("plate12").means, 0.5)  # 7 and 1
    drives = {
        info.labels["item"]: store.read(info.id).streams["drive"] for info in store.index if not info.material
    }
    assert np.abs(drives["signal01"].samples).max() == pytest.approx(1, rel=1e-3)
    assert drives["signal02"].samples.shape == (1, 2500)


def test_amplitudes_become_signals_with_these_amplitudes(study):
    items = {item.name: item for item in keio_ultrasonic.find(study, rate=RATE)}
    [gauges] = keio_ultrasonic.read(items["plates/1/m01.csv"])
    [spectra] = keio_ultrasonic.read(items["plates/12_m01.csv"])
    assert gauges.streams["strain"].samples.shape == (4, 6250)
    given = np.loadtxt(study / "plates" / "12_m01.csv", delimiter=",")
    found = sensor_spectra(spectra.streams["strain"], Config())[:, 0]
    # Standardised again: a sum of sinusoids has the mean square of half the sum of the squared amplitudes.
    np.testing.assert_allclose(found, given / np.sqrt((given**2).sum(1, keepdims=True) / 2), atol=1e-4)
    [again] = keio_ultrasonic.read(items["plates/12_m01.csv"])
    assert again.id == spectra.id, "phases follow from the file's name"


def test_a_folder_of_another_layout_is_refused(tmp_path):
    (tmp_path / "plates").mkdir()
    with pytest.raises(DataError, match="must hold files with a number in their path below plates/"):
        keio_ultrasonic.find(tmp_path)
