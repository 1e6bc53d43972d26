"""Surfaces named after those of Saga et al.: imagined formulas, not measurements."""

from __future__ import annotations

from tactogram.datasets.simulate.surfaces import (
    Appearance,
    Cells,
    Grating,
    Particles,
    Roughness,
    Surface,
    Weave,
)

STROKING_30 = (
    Surface(  # loops
        "carpet1",
        (Particles(0.30, 1.7, 0.55, 0.75), Roughness(0.030, 1.2, 0.3, 6)),
        0.75, stiffness_n_m=1500, loss=0.6,
        look=Appearance((0.42, 0.10, 0.09), (0.12, 0.02, 0.02), 0.16, 1.5),
    ),
    Surface(  # ribs
        "carpet2",
        (Grating(3.4, 0.40, 0, 0.8, 0.35), Particles(0.9, 0.9, 0.18, 0.3), Roughness(0.030, 1.2, 0.3, 6)),
        0.70, stiffness_n_m=1900, loss=0.6,
        look=Appearance((0.13, 0.19, 0.33), (0.03, 0.04, 0.09), 0.16, 1.5),
    ),
    Surface(  # tufts in rows
        "carpet3",
        (Particles(0.22, 2.1, 0.70, 0.55), Particles(1.6, 0.7, 0.14, 0.0), Roughness(0.030, 1.2, 0.3, 6)),
        0.80, stiffness_n_m=1200, loss=0.7,
        look=Appearance((0.44, 0.36, 0.24), (0.14, 0.10, 0.06), 0.18, 1.5),
    ),
    Surface(  # scouring fibres
        "sponge-g",
        (Particles(2.4, 0.55, -0.22, 0.0), Roughness(0.055, 0.9, 0.4, 6)),
        0.85, 1.25, 15, stiffness_n_m=900, loss=0.5,
        look=Appearance((0.10, 0.30, 0.09), (0.02, 0.08, 0.02), 0.25, 1.0),
    ),
    Surface(  # open pores
        "sponge-y",
        (Particles(0.55, 0.55, -0.35, 0.5, 0.12), Particles(1.4, 0.28, -0.20, 0.0, 0.10), Roughness(0.012, 1.6, 0.3)),
        0.95, 1.3, 20, stiffness_n_m=500, loss=0.9,
        look=Appearance((0.86, 0.58, 0.08), (0.45, 0.24, 0.02), 0.04),
    ),
    Surface(  # beads of foam
        "sponge-b",
        (Cells(3.4, 0.16, 0.025), Roughness(0.005, 1.6, 0.3)),
        0.55, 1.35, 12, stiffness_n_m=6000, loss=0.2,
        look=Appearance((0.72, 0.77, 0.82), (0.52, 0.58, 0.66), 0.02, gloss=0.05),
    ),
    Surface(
        "stonetile1", (Roughness(0.022, 1.8, 0.10, 5),),
        0.45, look=Appearance((0.26, 0.25, 0.23), (0.16, 0.15, 0.14), 0.35, 2.0),
    ),
    Surface(  # pitted
        "stonetile2",
        (Roughness(0.014, 1.4, 0.3, 6), Particles(0.25, 0.5, -0.09, 0.0, 0.12)),
        0.42, look=Appearance((0.15, 0.14, 0.14), (0.05, 0.05, 0.05), 0.40, 1.0, gloss=0.02),
    ),
    Surface(  # split along layers
        "stonetile3",
        (Roughness(0.015, 2.0, 0.10, 5, 2.5), Grating(6.4, 0.06, 15, 1.5, 1.6)),
        0.40, look=Appearance((0.38, 0.33, 0.25), (0.22, 0.18, 0.13), 0.22, 8.0, 3.0),
    ),
    Surface(
        "whitetile1", (Roughness(0.0055, 1.8, 0.05, 3),),
        0.35, 1.3, 15, look=Appearance((0.66, 0.66, 0.64), None, 0.012, gloss=0.10),
    ),
    Surface(  # fluted
        "whitetile2",
        (Grating(6.4, 0.10, 0, 2.0), Roughness(0.0050, 1.8, 0.05, 3)),
        0.38, 1.3, 15, look=Appearance((0.63, 0.62, 0.57), None, 0.012, gloss=0.10),
    ),
    Surface(  # studded
        "whitetile3",
        (Particles(0.11, 1.3, 0.050, 0.85), Roughness(0.0050, 1.8, 0.05, 3)),
        0.40, 1.25, 12, look=Appearance((0.60, 0.62, 0.65), None, 0.012, gloss=0.10),
    ),
    Surface(
        "woodtile1",
        (Roughness(0.011, 1.6, 0.10, 6, 12.0), Grating(2.6, 0.018, 0, 2.0, 0.6)),
        0.45, look=Appearance((0.42, 0.22, 0.10), (0.24, 0.11, 0.04), 0.16, 6.0, 14.0),
    ),
    Surface(  # open grain
        "woodtile2",
        (Grating(4.2, 0.055, 0, 3.0, 0.7), Roughness(0.010, 1.4, 0.2, 6, 16.0)),
        0.50, look=Appearance((0.22, 0.10, 0.045), (0.10, 0.04, 0.02), 0.20, 5.0, 18.0),
    ),
    Surface(
        "woodtile3",
        (Roughness(0.013, 1.4, 0.25, 6, 6.0),),
        0.42, look=Appearance((0.60, 0.40, 0.20), (0.46, 0.28, 0.12), 0.10, 8.0, 10.0),
    ),
)  # fmt: skip

STROKING_9 = (
    Surface(  # blades
        "artificial-grass",
        (Particles(0.45, 0.9, 1.1, 0.6), Roughness(0.05, 1.2, 0.4, 6)),
        0.60, stiffness_n_m=2500, loss=0.4,
        look=Appearance((0.10, 0.36, 0.05), (0.01, 0.05, 0.01), 0.22, 1.0, 2.0),
    ),
    Surface(
        "cloth", (Weave(0.9, 0.07), Roughness(0.006, 1.8, 0.3)),
        0.45, stiffness_n_m=3000, loss=0.5, look=Appearance((0.22, 0.25, 0.42), (0.10, 0.11, 0.22), 0.06, 1.0),
    ),
    Surface(
        "carpet", (Particles(0.7, 1.1, 0.40, 0.6), Roughness(0.045, 1.3, 0.3, 6)),
        0.75, stiffness_n_m=4000, loss=0.4, look=Appearance((0.34, 0.20, 0.10), (0.10, 0.05, 0.03), 0.20, 1.0),
    ),
    Surface(  # granules
        "cork-sheet", (Cells(2.2, 0.07, 0.025), Roughness(0.018, 1.4, 0.3, 6)),
        0.65, 1.25, stiffness_n_m=8000, loss=0.4, look=Appearance((0.52, 0.31, 0.14), (0.20, 0.09, 0.04), 0.20, 1.5),
    ),
    Surface(
        "punched-plastic-sheet", (Particles(0.04, 1.5, -0.45, 1.0, 0.10), Roughness(0.0035, 2.0, 0.2, 3)),
        0.40, 1.2, look=Appearance((0.62, 0.64, 0.66), (0.10, 0.10, 0.11), 0.01, gloss=0.12),
    ),
    Surface(  # joints
        "tile",
        (Grating(10.24, -0.16, 0, 40), Grating(10.24, -0.16, 90, 40), Roughness(0.004, 2.0, 0.1, 3)),
        0.35, 1.2, look=Appearance((0.42, 0.55, 0.62), (0.20, 0.20, 0.20), 0.03, gloss=0.06),
    ),
    Surface(
        "luncheon-mat-01", (Weave(2.2, 0.30), Roughness(0.008, 1.8, 0.3)),
        0.50, stiffness_n_m=12000, look=Appearance((0.48, 0.13, 0.10), (0.16, 0.03, 0.03), 0.06, gloss=0.02),
    ),
    Surface(
        "luncheon-mat-02", (Grating(1.35, 0.14, 0, 0.7), Grating(5.1, 0.06, 90, 1.0), Roughness(0.006, 1.8, 0.3)),
        0.50, stiffness_n_m=15000, look=Appearance((0.56, 0.47, 0.25), (0.22, 0.17, 0.08), 0.08, 2.0, 3.0),
    ),
    Surface(
        "luncheon-mat-03", (Grating(3.4, 0.24, 0, 2.0), Roughness(0.010, 1.8, 0.3)),
        0.55, stiffness_n_m=15000, look=Appearance((0.10, 0.20, 0.15), (0.05, 0.10, 0.08), 0.06, gloss=0.015),
    ),
)  # fmt: skip
