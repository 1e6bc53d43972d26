"""Files of data sets that tests write, and their import."""

import numpy as np
import soundfile
from PIL import Image as Pillow

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset


def write_sound(path, seed, *, rate=44100, seconds=0.02, channels=1, subtype="PCM_16"):
    path.parent.mkdir(parents=True, exist_ok=True)
    samples = np.random.default_rng(seed).uniform(-0.5, 0.5, (round(rate * seconds), channels))
    soundfile.write(path, samples, rate, subtype=subtype)
    return soundfile.read(path, dtype="float32", always_2d=True)[0].T


def write_noise(path, seed):
    path.parent.mkdir(parents=True, exist_ok=True)
    soundfile.write(path, np.random.default_rng(seed).uniform(-0.5, 0.5, 100), 1000, subtype="FLOAT")


def write_photo(path, seed, *, rows=32, columns=48):
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), dtype=np.uint8)
    Pillow.fromarray(pixels).save(path, quality=95)


def imported(name, source, tmp_path, **options):
    report = import_dataset(name, source, tmp_path / "store", **options)
    return report, open_store(tmp_path / "store")


def imported_alone(name, source, tmp_path, **options):
    report = import_dataset(name, source, tmp_path / "store", workers=1, **options)
    return report, open_store(tmp_path / "store")
