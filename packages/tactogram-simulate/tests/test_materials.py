"""Table of the simulated surfaces."""

import numpy as np
import pytest
from scipy.signal import welch

from tactogram.datasets.everyday import KIND_OF
from tactogram_simulate import make, tasks
from tactogram_simulate.materials import (
    EVERYDAY,
    KINDS,
    PLATES,
    STROKING_9,
    STROKING_30,
    surfaces_of,
)
from tactogram_simulate.random_surfaces import FORCES_N, SPEEDS_MM_S
from tactogram_simulate.stroke import RecordingTask
from tactogram_simulate.surfaces import Appearance, Cells, Grating, Roughness, Surface


def test_a_row_is_the_surface_it_says():
    cork = Surface(
        "cork-sheet", (Cells(2.2, 0.07, 0.025), Roughness(0.018, 1.4, 0.3, 6)), 0.65, 1.25,
        stiffness_n_m=8000, loss=0.4, look=Appearance((0.52, 0.31, 0.14), (0.20, 0.09, 0.04), 0.20, 1.5),
    )  # fmt: skip
    assert cork in STROKING_9
    assert PLATES[6].surface.textures == (Grating(0.8, 0.06, 0, 3.0), Grating(0.8, 0.06, 90, 3.0))
    assert (PLATES[6].name, PLATES[6].fine_um) == ("plate07", 1.5)


def test_empty_cells_have_the_default():
    glass = next(surface for surface in EVERYDAY if surface.name == "glass")
    assert (glass.stiffness_n_m, glass.loss, glass.look.hollow, glass.look.streak) == (1e5, 0.0, None, 1.0)
    assert glass.ground == Roughness(0.0142, 3.34, 0.05, 8.0)


def test_every_set_has_its_surfaces():
    counts = map(len, (EVERYDAY, STROKING_30, STROKING_9, PLATES, surfaces_of("fabrics")))
    assert list(counts) == [84, 15, 9, 12, 6]


def strokes(name, speed):
    number = [surface.name for surface in EVERYDAY].index(name)
    found = tasks("everyday", seed=0, per_class=1, seconds=1.0, speeds_mm_s=[speed])
    return make(found[number]).streams["acceleration"].samples


def test_names_are_different_and_each_is_of_a_kind():
    names = [surface.name for surface in EVERYDAY]
    assert len(set(names)) == len(names)
    assert [*KIND_OF] == names
    assert set(KINDS) == set(KIND_OF.values())


@pytest.mark.parametrize("kind", ["fabric", "mineral"])
def test_a_kind_has_the_level_of_its_real_materials(kind):
    """By a stylus at 120 mm/s and 1 N, 20 to 480 Hz, other strokes than the heights were set with."""
    names = [surface.name for surface in EVERYDAY]
    found = []
    for name in [name for name, its in KIND_OF.items() if its == kind][:4]:
        task = RecordingTask(
            "everyday", 9, names.index(name), "stylus", 120.0, 1, 2.0, 2500.0, 1.0, own_image=False
        )
        signal = make(task).streams["acceleration"].samples
        frequency, density = welch(signal, 2500, nperseg=1024)
        band = (frequency >= 20) & (frequency <= 480)
        found.append(10 * np.log10(density[:, band].sum() * frequency[1]))
    assert np.mean(found) == pytest.approx(KINDS[kind].level_db, abs=3.5)


def test_each_stroke_has_a_speed_and_a_force_of_its_own():
    found = tasks("everyday", seed=0, own_images=False)
    assert len(found) == 8 * len(EVERYDAY)
    assert {task.contactor for task in found} == {"finger", "stylus"}
    assert len({(task.speed_mm_s, task.force_n) for task in found}) > 0.99 * len(found)
    for limits, values in (
        (SPEEDS_MM_S, [task.speed_mm_s for task in found]),
        (FORCES_N, [task.force_n for task in found]),
    ):
        assert limits[0] <= min(values) < 1.2 * limits[0]
        assert limits[1] >= max(values) > 0.8 * limits[1]


def test_ribs_are_felt_at_the_speed_over_their_period():
    x = strokes("ribbed-rubber-mat", 140.0)[2][200:-200]
    density = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    frequency = np.fft.rfftfreq(len(x), 1 / 2500)
    band = (frequency > 20) & (frequency < 65)
    assert frequency[band][density[band].argmax()] == pytest.approx(140 / 3.5, rel=0.2)
