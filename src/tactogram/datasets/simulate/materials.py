"""The surfaces of Saga et al. by name, as we imagine them: formulas with the names of the paper, not measurements."""

from __future__ import annotations

from tactogram.datasets.simulate.surfaces import Grating, Particles, Roughness, Surface, Weave

STROKING_30 = (
    Surface(
        "carpet1",
        (Particles(0.55, 1.3, 0.50, 0.6), Roughness(0.030, 1.6, 0.3)),
        0.75, stiffness_n_m=1500, damping=0.35, colour=(0.45, 0.18, 0.16), mottle=0.12,
    ),
    Surface(
        "carpet2",
        (Grating(3.2, 0.26, 0, 1.0, 0.35), Roughness(0.035, 1.6, 0.3)),
        0.70, stiffness_n_m=1800, damping=0.3, colour=(0.25, 0.30, 0.42), mottle=0.10,
    ),
    Surface(
        "carpet3",
        (Particles(0.25, 1.9, 0.70, 0.5), Grating(2.4, 0.12, 90, 1.0, 0.3), Roughness(0.03, 1.8, 0.3)),
        0.80, stiffness_n_m=1200, damping=0.4, colour=(0.47, 0.42, 0.33), mottle=0.12,
    ),
    Surface(
        "sponge-g",
        (Particles(3.0, 0.5, -0.16, 0.2), Roughness(0.020, 1.2, 0.5)),
        0.85, 1.25, 15, stiffness_n_m=900, damping=0.35, colour=(0.30, 0.48, 0.25), mottle=0.08,
    ),
    Surface(
        "sponge-y",
        (Particles(1.2, 0.9, -0.30, 0.3), Roughness(0.012, 1.8, 0.3)),
        0.95, 1.3, 20, stiffness_n_m=500, damping=0.5, colour=(0.85, 0.72, 0.25), mottle=0.06,
    ),
    Surface(
        "sponge-b",
        (Particles(0.16, 2.6, 0.16, 0.55), Roughness(0.006, 1.6, 0.3)),
        0.55, 1.35, 12, stiffness_n_m=6000, damping=0.15, colour=(0.85, 0.87, 0.90), mottle=0.03,
    ),
    Surface("stonetile1", (Roughness(0.020, 2.0, 0.15, 4),), 0.45, colour=(0.50, 0.49, 0.47), mottle=0.20),
    Surface(
        "stonetile2",
        (Roughness(0.012, 1.5, 0.3, 5), Particles(0.4, 0.6, -0.03)),
        0.42, colour=(0.40, 0.38, 0.37), mottle=0.22,
    ),
    Surface(
        "stonetile3",
        (Roughness(0.013, 2.2, 0.15, 4), Grating(5.5, 0.05, 20, 1.0, 1.2)),
        0.40, colour=(0.56, 0.52, 0.45), mottle=0.22,
    ),
    Surface("whitetile1", (Roughness(0.0050, 2.0, 0.1, 3),), 0.35, 1.3, 15, colour=(0.92, 0.92, 0.91), mottle=0.02),
    Surface(
        "whitetile2",
        (Grating(6.4, 0.05, 0, 2.0), Roughness(0.0045, 2.0, 0.1, 3)),
        0.38, 1.3, 15, colour=(0.90, 0.90, 0.87), mottle=0.02,
    ),
    Surface(
        "whitetile3",
        (Particles(0.9, 0.7, 0.030, 0.9), Roughness(0.0040, 2.0, 0.1, 3)),
        0.40, 1.25, 12, colour=(0.93, 0.92, 0.94), mottle=0.02,
    ),
    Surface(
        "woodtile1",
        (Roughness(0.009, 1.8, 0.15, 5, 6.0), Grating(1.1, 0.010, 0, 1.0, 0.5)),
        0.45, colour=(0.56, 0.38, 0.22), mottle=0.14,
    ),
    Surface(
        "woodtile2",
        (Grating(2.2, 0.05, 0, 1.5, 0.2), Roughness(0.007, 1.8, 0.2, 5, 6.0)),
        0.50, colour=(0.42, 0.26, 0.15), mottle=0.14,
    ),
    Surface(
        "woodtile3",
        (Roughness(0.011, 1.6, 0.25, 5, 3.0),),
        0.42, colour=(0.66, 0.50, 0.32), mottle=0.14,
    ),
)  # fmt: skip

STROKING_9 = (
    Surface(
        "artificial-grass",
        (Particles(0.14, 1.7, 1.6, 0.75), Roughness(0.02, 1.6, 0.3)),
        0.60, stiffness_n_m=2500, damping=0.2, colour=(0.22, 0.45, 0.18), mottle=0.12,
    ),
    Surface(
        "cloth", (Weave(0.9, 0.05), Roughness(0.006, 1.8, 0.3)),
        0.45, stiffness_n_m=3000, damping=0.3, colour=(0.50, 0.52, 0.66), mottle=0.05,
    ),
    Surface(
        "carpet", (Particles(0.7, 1.1, 0.40, 0.6), Roughness(0.045, 1.5, 0.3)),
        0.75, stiffness_n_m=4000, damping=0.2, colour=(0.46, 0.22, 0.17), mottle=0.14,
    ),
    Surface(
        "cork-sheet", (Roughness(0.028, 1.6, 0.3, 4), Particles(0.6, 0.7, -0.06)),
        0.65, 1.25, stiffness_n_m=8000, damping=0.2, colour=(0.66, 0.46, 0.28), mottle=0.25,
    ),
    Surface(
        "punched-plastic-sheet", (Particles(0.06, 2.6, -0.55, 1.0), Roughness(0.0035, 2.0, 0.2, 3)),
        0.40, 1.2, colour=(0.82, 0.83, 0.85), mottle=0.02,
    ),
    Surface(
        "tile", (Grating(10.24, 0.10, 0, 0.25), Grating(10.24, 0.10, 90, 0.25), Roughness(0.004, 2.0, 0.1, 3)),
        0.35, 1.2, colour=(0.72, 0.78, 0.82), mottle=0.04,
    ),
    Surface(
        "luncheon-mat-01", (Weave(2.2, 0.28), Roughness(0.008, 1.8, 0.3)),
        0.50, stiffness_n_m=12000, colour=(0.62, 0.30, 0.26), mottle=0.06,
    ),
    Surface(
        "luncheon-mat-02", (Grating(1.35, 0.12, 0, 1.0), Grating(5.1, 0.05, 90, 1.0), Roughness(0.006, 1.8, 0.3)),
        0.50, stiffness_n_m=15000, colour=(0.70, 0.64, 0.48), mottle=0.06,
    ),
    Surface(
        "luncheon-mat-03", (Grating(3.4, 0.24, 0, 2.0), Roughness(0.010, 1.8, 0.3)),
        0.55, stiffness_n_m=15000, colour=(0.30, 0.40, 0.34), mottle=0.06,
    ),
)  # fmt: skip
