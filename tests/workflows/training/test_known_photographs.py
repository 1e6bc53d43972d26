"""Photographs of a run: described, found again, and damaged."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactogram.errors import RunError
from tactogram.signal import Image
from tactogram.training.run import Run
from tactogram.workflows.training.known_photographs import FILE, known_photographs, save_photographs


def photograph(material, seed):
    bright = {"cork": 60, "felt": 128, "tile": 200, "wool": 230}[material]
    noise = np.random.default_rng(seed).integers(-20, 20, (48, 48, 3))
    return Image(np.uint8(bright + noise))


def examples(*materials):
    return [
        SimpleNamespace(material=name, photographs=[photograph(name, 10 * k + n) for n in range(3)])
        for k, name in enumerate(materials)
    ]


def test_a_photograph_of_the_training_is_found_and_one_unlike_all_is_new(tmp_path):
    run = Run(tmp_path)
    save_photographs(run, trained := examples("cork", "felt", "tile", "wool"))
    known = known_photographs(run)
    for example in trained:
        for image in example.photographs:
            assert (known.nearest(image).material, known.nearest(image).novelty) == (example.material, 0)
    checks = np.indices((48, 48)).sum(0) // 8 % 2 * 255
    assert known.nearest(Image(np.repeat(np.uint8(checks)[..., None], 3, axis=2))).novelty == 1


def test_one_material_has_nothing_to_compare(tmp_path):
    save_photographs(Run(tmp_path), examples("cork"))
    assert not (tmp_path / FILE).exists()
    assert known_photographs(Run(tmp_path)) is None


def test_a_damaged_file_is_named(tmp_path):
    (tmp_path / FILE).write_text("{}")
    with pytest.raises(RunError, match=rf"{FILE}: lacks or misspells .*; it is damaged, delete it"):
        known_photographs(Run(tmp_path))
