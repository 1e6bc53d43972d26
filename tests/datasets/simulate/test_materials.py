"""Table of the simulated surfaces."""

from tactogram.datasets.simulate.everyday import EVERYDAY
from tactogram.datasets.simulate.materials import STROKING_9, STROKING_30, surfaces_of
from tactogram.datasets.simulate.metal_plates import PLATES
from tactogram.datasets.simulate.surfaces import Appearance, Cells, Grating, Roughness, Surface


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
