"""Everyday surfaces by their usual names: invented height fields with plausible dimensions.

Their level and the slope of their spectrum are set to means of real materials of their kind (`KINDS`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from tactogram.datasets.simulate.surfaces import (
    Appearance,
    Cells,
    Grating,
    Particles,
    Roughness,
    Surface,
    Weave,
)

FABRICS = (
    Surface(
        "cotton-sheet", (Weave(0.45, 0.03), Roughness(0.006, 1.6, 0.3, 6)),
        0.45, stiffness_n_m=4000, loss=0.5, look=Appearance((0.75, 0.74, 0.70), None, 0.03, 1.0),
    ),
    Surface(  # slubs
        "linen", (Weave(0.8, 0.08), Roughness(0.015, 1.4, 0.2, 6, 3.0)),
        0.45, stiffness_n_m=4500, loss=0.4, look=Appearance((0.58, 0.50, 0.37), (0.30, 0.25, 0.17), 0.10, 2.0, 3.0),
    ),
    Surface(  # twill
        "denim", (Grating(0.9, 0.09, 55, 1.0, 0.1), Weave(0.9, 0.05), Roughness(0.012, 1.4, 0.3, 6)),
        0.50, stiffness_n_m=6000, loss=0.4, look=Appearance((0.08, 0.12, 0.24), (0.20, 0.24, 0.33), 0.12, 1.0),
    ),
    Surface(
        "canvas", (Weave(1.3, 0.16), Roughness(0.012, 1.5, 0.3, 6)),
        0.50, stiffness_n_m=8000, loss=0.3, look=Appearance((0.66, 0.62, 0.52), (0.40, 0.36, 0.28), 0.06, 1.0),
    ),
    Surface(  # sacking
        "burlap", (Weave(2.8, 0.55), Roughness(0.040, 1.1, 0.3, 6, 2.0)),
        0.55, stiffness_n_m=4000, loss=0.4, look=Appearance((0.42, 0.28, 0.13), (0.12, 0.07, 0.03), 0.18, 1.0),
    ),
    Surface(
        "silk", (Weave(0.35, 0.010), Roughness(0.003, 1.8, 0.2, 4)),
        0.28, 1.1, stiffness_n_m=5000, loss=0.4, look=Appearance((0.55, 0.10, 0.14), None, 0.02, 2.0, gloss=0.06),
    ),
    Surface(  # floats along one direction
        "satin", (Grating(0.5, 0.012, 90), Roughness(0.003, 1.8, 0.2, 4, 4.0)),
        0.25, 1.1, stiffness_n_m=5000, loss=0.4, look=Appearance((0.62, 0.46, 0.55), None, 0.02, 2.0, gloss=0.10),
    ),
    Surface(  # upright pile
        "velvet", (Particles(9.0, 0.25, 0.10, 0.4), Roughness(0.020, 1.0, 0.4, 6)),
        0.55, 1.1, stiffness_n_m=900, loss=0.9, look=Appearance((0.25, 0.02, 0.06), (0.06, 0.0, 0.01), 0.10, 1.5),
    ),
    Surface(  # wales
        "corduroy", (Grating(2.5, 0.55, 0, 0.8, 0.05), Roughness(0.025, 1.1, 0.4, 6, 2.0)),
        0.60, stiffness_n_m=2500, loss=0.7, look=Appearance((0.40, 0.24, 0.10), (0.15, 0.08, 0.03), 0.08, 1.0),
    ),
    Surface(  # loops
        "terry-towel", (Particles(0.55, 1.0, 0.65, 0.5), Roughness(0.050, 1.1, 0.3, 6)),
        0.75, stiffness_n_m=1200, loss=0.8, look=Appearance((0.70, 0.70, 0.66), (0.45, 0.45, 0.42), 0.08, 1.0),
    ),
    Surface(
        "wool-knit", (Weave(3.6, 0.75), Roughness(0.060, 1.0, 0.3, 6)),
        0.65, stiffness_n_m=1000, loss=0.8, look=Appearance((0.45, 0.40, 0.33), (0.15, 0.13, 0.10), 0.12, 1.0),
    ),
    Surface(  # matted fibres
        "felt", (Roughness(0.045, 1.2, 0.15, 6),),
        0.60, stiffness_n_m=3000, loss=0.7, look=Appearance((0.10, 0.28, 0.22), (0.05, 0.15, 0.12), 0.12, 1.0),
    ),
    Surface(
        "fleece", (Particles(1.2, 0.8, 0.30, 0.0), Roughness(0.040, 1.1, 0.3, 6)),
        0.50, 1.1, stiffness_n_m=600, loss=0.9, look=Appearance((0.20, 0.30, 0.45), (0.12, 0.18, 0.30), 0.10, 1.0),
    ),
    Surface(
        "faux-fur", (Roughness(0.220, 1.4, 0.10, 4, 3.0), Roughness(0.060, 0.9, 0.6, 6)),
        0.45, 1.1, stiffness_n_m=400, loss=0.9, look=Appearance((0.34, 0.24, 0.16), (0.10, 0.07, 0.04), 0.25, 2.0, 4.0),
    ),
    Surface(
        "microfibre-cloth", (Particles(4.5, 0.4, 0.10, 0.2), Roughness(0.022, 1.2, 0.4, 6)),
        0.85, 1.25, stiffness_n_m=1500, loss=0.7, look=Appearance((0.20, 0.45, 0.60), None, 0.06, 1.0),
    ),
    Surface(
        "gauze", (Weave(1.6, 0.22), Roughness(0.010, 1.4, 0.3, 6)),
        0.40, stiffness_n_m=1500, loss=0.6, look=Appearance((0.80, 0.80, 0.78), (0.40, 0.40, 0.40), 0.04, 1.0),
    ),
    Surface(
        "nylon-webbing", (Grating(1.8, 0.35, 0, 0.8), Grating(3.6, 0.15, 90), Roughness(0.008, 1.6, 0.3, 6)),
        0.40, stiffness_n_m=15000, loss=0.2, look=Appearance((0.05, 0.05, 0.06), None, 0.04, 1.0, gloss=0.03),
    ),
)  # fmt: skip

FLOORS = (
    Surface(
        "loop-carpet", (Particles(0.30, 1.6, 0.60, 0.8), Roughness(0.035, 1.2, 0.3, 6)),
        0.75, stiffness_n_m=2500, loss=0.6, look=Appearance((0.35, 0.33, 0.30), (0.12, 0.11, 0.10), 0.15, 1.5),
    ),
    Surface(  # long pile
        "shag-rug", (Roughness(0.350, 1.3, 0.08, 3), Particles(0.15, 2.2, 0.60, 0.2), Roughness(0.050, 1.0, 0.5, 6)),
        0.70, stiffness_n_m=500, loss=0.9, look=Appearance((0.70, 0.66, 0.58), (0.30, 0.27, 0.22), 0.18, 2.0, 2.0),
    ),
    Surface(  # bristles
        "coir-doormat", (Particles(1.4, 0.5, 0.80, 0.3), Roughness(0.090, 0.9, 0.4, 6)),
        0.80, 1.2, stiffness_n_m=6000, loss=0.3, look=Appearance((0.32, 0.19, 0.08), (0.08, 0.04, 0.02), 0.30, 1.0),
    ),
    Surface(
        "artificial-turf", (Particles(0.45, 0.9, 1.1, 0.6), Roughness(0.05, 1.2, 0.4, 6)),
        0.60, stiffness_n_m=2500, loss=0.4, look=Appearance((0.10, 0.36, 0.05), (0.01, 0.05, 0.01), 0.22, 1.0, 2.0),
    ),
    Surface(  # rushes
        "straw-mat", (Grating(2.0, 0.30, 0, 0.7, 0.2), Grating(9.0, 0.12, 90, 2.0), Roughness(0.010, 1.5, 0.3, 6, 8.0)),
        0.40, stiffness_n_m=12000, loss=0.2, look=Appearance((0.60, 0.55, 0.28), (0.25, 0.21, 0.08), 0.10, 3.0, 6.0),
    ),
    Surface(
        "bamboo-mat", (Grating(5.0, 0.70, 0, 0.6, 0.1), Roughness(0.006, 1.6, 0.3, 6, 12.0)),
        0.40, stiffness_n_m=40000, look=Appearance((0.52, 0.38, 0.17), (0.12, 0.08, 0.03), 0.10, 5.0, 14.0, gloss=0.03),
    ),
    Surface(  # embossed
        "vinyl-flooring", (Roughness(0.012, 1.8, 0.10, 3), Particles(0.20, 1.0, 0.04, 0.2)),
        0.60, 1.2, stiffness_n_m=30000, loss=0.2, look=Appearance((0.38, 0.28, 0.18), None, 0.10, 5.0, 6.0, gloss=0.05),
    ),
)  # fmt: skip

PAPERS = (
    Surface(
        "printer-paper", (Roughness(0.005, 1.6, 0.2, 6),),
        0.42, look=Appearance((0.86, 0.86, 0.84), None, 0.01, 2.0),
    ),
    Surface(
        "cardboard", (Roughness(0.010, 1.7, 0.15, 6), Grating(6.0, 0.012, 0, 1.0, 0.3)),
        0.45, stiffness_n_m=20000, loss=0.2, look=Appearance((0.45, 0.31, 0.17), None, 0.08, 2.0),
    ),
    Surface(  # flutes
        "corrugated-cardboard", (Grating(7.2, 1.0, 0, 0.9, 0.1), Roughness(0.012, 1.6, 0.2, 6)),
        0.45, stiffness_n_m=15000, loss=0.2, look=Appearance((0.45, 0.31, 0.17), (0.22, 0.14, 0.07), 0.08, 2.0),
    ),
    Surface(  # embossed
        "paper-towel", (Particles(0.12, 1.3, 0.30, 1.0), Roughness(0.020, 1.3, 0.3, 6)),
        0.45, stiffness_n_m=2000, loss=0.5, look=Appearance((0.82, 0.82, 0.80), None, 0.02, 1.0),
    ),
    Surface(
        "wallpaper", (Roughness(0.060, 2.0, 0.10, 1.2), Roughness(0.008, 1.5, 0.3, 6)),
        0.45, look=Appearance((0.72, 0.68, 0.58), None, 0.04, 2.0),
    ),
    Surface(
        "fine-sandpaper", (Particles(25.0, 0.12, 0.035, 0.0), Roughness(0.008, 1.0, 0.5, 6)),
        0.70, look=Appearance((0.28, 0.20, 0.15), None, 0.12, 0.5),
    ),
    Surface(
        "sandpaper", (Particles(8.0, 0.22, 0.09, 0.0), Roughness(0.015, 1.0, 0.5, 6)),
        0.80, 1.2, look=Appearance((0.34, 0.16, 0.08), (0.20, 0.09, 0.05), 0.20, 0.5),
    ),
    Surface(
        "coarse-sandpaper", (Particles(1.8, 0.45, 0.26, 0.0), Roughness(0.030, 1.0, 0.4, 6)),
        0.90, 1.2, look=Appearance((0.30, 0.12, 0.06), (0.12, 0.05, 0.03), 0.30, 0.8),
    ),
    Surface(  # dots of 6-dot cells
        "braille-page", (Particles(0.10, 0.75, 0.48, 0.7), Roughness(0.005, 1.6, 0.2, 6)),
        0.42, look=Appearance((0.78, 0.74, 0.64), None, 0.02, 2.0),
    ),
)  # fmt: skip

WOODS = (
    Surface(
        "polished-wood", (Roughness(0.004, 1.8, 0.05, 3, 10.0),),
        0.50, 1.25, 12, look=Appearance((0.30, 0.13, 0.05), (0.20, 0.08, 0.03), 0.14, 6.0, 14.0, gloss=0.10),
    ),
    Surface(
        "pine-board", (Roughness(0.012, 1.5, 0.15, 6, 10.0), Grating(4.5, 0.03, 0, 2.0, 0.9)),
        0.45, look=Appearance((0.62, 0.43, 0.22), (0.48, 0.30, 0.13), 0.08, 8.0, 14.0),
    ),
    Surface(  # open pores
        "oak", (Grating(2.4, 0.05, 0, 3.0, 0.6), Roughness(0.010, 1.4, 0.2, 6, 16.0)),
        0.48, look=Appearance((0.40, 0.25, 0.12), (0.20, 0.11, 0.05), 0.15, 5.0, 18.0),
    ),
    Surface(  # saw marks
        "rough-sawn-wood", (Grating(3.2, 0.14, 70, 1.0, 0.5), Roughness(0.070, 1.2, 0.2, 6, 5.0)),
        0.65, look=Appearance((0.55, 0.42, 0.26), (0.35, 0.25, 0.14), 0.18, 3.0, 5.0),
    ),
    Surface(
        "plywood", (Roughness(0.014, 1.5, 0.2, 6, 8.0),),
        0.45, look=Appearance((0.58, 0.42, 0.24), (0.46, 0.31, 0.16), 0.12, 6.0, 8.0),
    ),
    Surface(
        "chipboard", (Cells(3.0, 0.03, 0.02), Roughness(0.020, 1.5, 0.2, 6, 2.0)),
        0.50, look=Appearance((0.54, 0.42, 0.28), (0.34, 0.25, 0.15), 0.22, 3.0, 2.0),
    ),
    Surface(  # deep furrows
        "tree-bark", (Grating(8.0, 0.90, 0, 1.4, 2.2), Roughness(0.150, 1.5, 0.1, 5, 2.0)),
        0.70, 1.2, look=Appearance((0.20, 0.14, 0.09), (0.05, 0.03, 0.02), 0.30, 3.0, 4.0),
    ),
    Surface(
        "cork", (Cells(2.2, 0.07, 0.025), Roughness(0.018, 1.4, 0.3, 6)),
        0.65, 1.25, stiffness_n_m=8000, loss=0.4, look=Appearance((0.52, 0.31, 0.14), (0.20, 0.09, 0.04), 0.20, 1.5),
    ),
)  # fmt: skip

LEATHERS_AND_RUBBERS = (
    Surface(
        "smooth-leather", (Cells(1.2, 0.012, 0.003), Roughness(0.004, 1.7, 0.2, 5)),
        0.60, 1.2, stiffness_n_m=10000, loss=0.5, look=Appearance((0.18, 0.08, 0.04), None, 0.06, 1.0, gloss=0.08),
    ),
    Surface(
        "grained-leather", (Cells(1.8, 0.09, 0.02), Roughness(0.006, 1.7, 0.2, 5)),
        0.60, 1.2, stiffness_n_m=9000, loss=0.5,
        look=Appearance((0.10, 0.05, 0.03), (0.05, 0.02, 0.01), 0.06, 1.0, gloss=0.05),
    ),
    Surface(  # nap
        "suede", (Roughness(0.028, 1.1, 0.4, 6),),
        0.70, 1.1, stiffness_n_m=4000, loss=0.7, look=Appearance((0.42, 0.26, 0.14), (0.32, 0.19, 0.10), 0.12, 1.5),
    ),
    Surface(
        "rubber-sheet", (Roughness(0.006, 1.8, 0.1, 4),),
        0.95, 1.35, 18, stiffness_n_m=6000, loss=0.8, look=Appearance((0.03, 0.03, 0.03), None, 0.03, 2.0, gloss=0.02),
    ),
    Surface(
        "ribbed-rubber-mat", (Grating(3.5, 0.90, 0, 0.7), Roughness(0.006, 1.8, 0.1, 4)),
        0.90, 1.3, 18, stiffness_n_m=7000, loss=0.7, look=Appearance((0.03, 0.03, 0.03), (0.01, 0.01, 0.01), 0.03, 2.0),
    ),
    Surface(
        "silicone", (Roughness(0.004, 1.9, 0.1, 4),),
        1.00, 1.35, 20, stiffness_n_m=2500, loss=0.9, look=Appearance((0.75, 0.30, 0.34), None, 0.01, 2.0, gloss=0.04),
    ),
    Surface(
        "yoga-mat", (Cells(1.6, 0.10, 0.02), Roughness(0.006, 1.6, 0.3, 5)),
        0.95, 1.3, 18, stiffness_n_m=2500, loss=0.8, look=Appearance((0.25, 0.20, 0.42), None, 0.02, 1.0),
    ),
)  # fmt: skip

FOAMS = (
    Surface(
        "kitchen-sponge",
        (Particles(0.55, 0.55, -0.35, 0.5, 0.12), Particles(1.4, 0.28, -0.20, 0.0, 0.10), Roughness(0.012, 1.6, 0.3)),
        0.90, 1.3, 20, stiffness_n_m=600, loss=0.9, look=Appearance((0.86, 0.58, 0.08), (0.45, 0.24, 0.02), 0.04),
    ),
    Surface(  # mineral in fibres
        "scouring-pad", (Particles(2.4, 0.55, -0.22, 0.0), Roughness(0.070, 0.9, 0.4, 6)),
        0.85, 1.2, stiffness_n_m=2500, loss=0.4, look=Appearance((0.05, 0.22, 0.08), (0.01, 0.05, 0.02), 0.25, 1.0),
    ),
    Surface(  # beads
        "polystyrene-foam", (Cells(3.4, 0.16, 0.025), Roughness(0.005, 1.6, 0.3)),
        0.60, 1.35, 12, stiffness_n_m=8000, loss=0.2,
        look=Appearance((0.84, 0.85, 0.86), (0.66, 0.67, 0.69), 0.01, gloss=0.03),
    ),
    Surface(
        "foam-rubber", (Particles(5.0, 0.25, -0.10, 0.0, 0.10), Roughness(0.012, 1.4, 0.3, 6)),
        0.85, 1.25, 15, stiffness_n_m=500, loss=0.9, look=Appearance((0.80, 0.78, 0.62), (0.60, 0.58, 0.44), 0.02, 1.0),
    ),
    Surface(
        "bubble-wrap", (Particles(0.0095, 4.8, 2.0, 1.0), Roughness(0.003, 2.0, 0.1, 3)),
        0.60, 1.3, 15, stiffness_n_m=1200, loss=0.5, look=Appearance((0.70, 0.72, 0.74), None, 0.02, gloss=0.15),
    ),
)  # fmt: skip

PLASTICS = (
    Surface(
        "smooth-plastic", (Roughness(0.003, 2.0, 0.1, 3),),
        0.50, 1.25, 12, look=Appearance((0.60, 0.06, 0.05), None, 0.01, gloss=0.10),
    ),
    Surface(  # spark-eroded mould
        "textured-plastic", (Particles(6.0, 0.25, 0.035, 0.0), Roughness(0.008, 1.5, 0.3, 6)),
        0.40, look=Appearance((0.05, 0.05, 0.05), None, 0.04, 0.5, gloss=0.01),
    ),
    Surface(
        "studded-plastic", (Particles(0.0156, 2.4, 1.7, 1.0, 0.10), Roughness(0.003, 2.0, 0.1, 3)),
        0.40, 1.2, look=Appearance((0.05, 0.30, 0.10), None, 0.01, gloss=0.10),
    ),
    Surface(
        "hair-comb", (Grating(2.0, 1.2, 0, 0.6), Roughness(0.003, 2.0, 0.1, 3)),
        0.40, 1.2, look=Appearance((0.06, 0.04, 0.03), (0.0, 0.0, 0.0), 0.01, gloss=0.10),
    ),
    Surface(
        "plastic-mesh", (Grating(2.6, 0.70, 0, 0.6), Grating(2.6, 0.70, 90, 0.6), Roughness(0.004, 2.0, 0.1, 3)),
        0.45, 1.2, stiffness_n_m=30000, look=Appearance((0.10, 0.40, 0.25), (0.01, 0.05, 0.03), 0.02, gloss=0.06),
    ),
    Surface(
        "zip", (Grating(1.6, 0.55, 0, 0.6), Roughness(0.006, 1.6, 0.2, 5)),
        0.35, 1.15, look=Appearance((0.45, 0.40, 0.28), (0.10, 0.09, 0.06), 0.03, gloss=0.10),
    ),
    Surface(
        "plastic-film", (Roughness(0.010, 2.2, 0.03, 1.0),),
        0.70, 1.35, 18, stiffness_n_m=20000, loss=0.3, look=Appearance((0.70, 0.72, 0.75), None, 0.01, gloss=0.15),
    ),
)  # fmt: skip

STONES = (
    Surface(
        "glass", (Roughness(0.0020, 2.2, 0.05, 2),),
        0.55, 1.3, 15, look=Appearance((0.45, 0.55, 0.55), None, 0.004, gloss=0.15),
    ),
    Surface(
        "frosted-glass", (Roughness(0.007, 1.3, 0.4, 6),),
        0.45, 1.15, look=Appearance((0.62, 0.66, 0.66), None, 0.01, 0.5, gloss=0.02),
    ),
    Surface(  # joints
        "glazed-tiles", (Grating(25.6, -0.35, 0, 90), Grating(25.6, -0.35, 90, 90), Roughness(0.004, 2.0, 0.1, 3)),
        0.40, 1.25, 12, look=Appearance((0.70, 0.72, 0.72), (0.40, 0.40, 0.38), 0.02, gloss=0.12),
    ),
    Surface(
        "terracotta", (Roughness(0.022, 1.6, 0.15, 6),),
        0.60, look=Appearance((0.52, 0.22, 0.11), None, 0.12, 2.0),
    ),
    Surface(
        "polished-marble", (Roughness(0.0030, 2.0, 0.05, 3),),
        0.45, 1.25, 12, look=Appearance((0.74, 0.73, 0.71), None, 0.06, 8.0, 2.0, gloss=0.12),
    ),
    Surface(
        "rough-granite", (Cells(1.8, 0.10, 0.06), Roughness(0.060, 1.5, 0.1, 6)),
        0.60, look=Appearance((0.36, 0.34, 0.33), (0.20, 0.19, 0.19), 0.35, 1.5),
    ),
    Surface(  # split along layers
        "slate", (Roughness(0.020, 2.0, 0.08, 5, 2.5), Grating(9.0, 0.10, 15, 1.5, 2.5)),
        0.45, look=Appearance((0.12, 0.13, 0.15), None, 0.15, 6.0, 3.0),
    ),
    Surface(
        "sandstone", (Particles(6.0, 0.28, 0.10, 0.0), Roughness(0.040, 1.6, 0.1, 6)),
        0.75, look=Appearance((0.58, 0.44, 0.28), (0.46, 0.33, 0.20), 0.14, 1.5),
    ),
    Surface(
        "concrete", (Roughness(0.055, 1.7, 0.08, 6), Particles(0.06, 1.0, -0.35, 0.0, 0.15)),
        0.70, look=Appearance((0.42, 0.41, 0.39), (0.26, 0.25, 0.24), 0.14, 3.0),
    ),
    Surface(
        "brick", (Roughness(0.090, 1.6, 0.08, 6), Particles(0.35, 0.7, -0.25, 0.0, 0.15)),
        0.75, look=Appearance((0.40, 0.14, 0.08), (0.22, 0.08, 0.05), 0.20, 2.0),
    ),
    Surface(
        "asphalt", (Cells(5.0, 0.90, 0.30), Roughness(0.110, 1.4, 0.15, 6)),
        0.80, look=Appearance((0.10, 0.10, 0.10), (0.02, 0.02, 0.02), 0.30, 2.0),
    ),
    Surface(
        "plaster-wall", (Roughness(0.025, 1.9, 0.05, 5),),
        0.60, look=Appearance((0.80, 0.79, 0.75), None, 0.02, 4.0),
    ),
    Surface(  # drops of paint and stone
        "roughcast", (Particles(0.16, 1.4, 1.0, 0.0), Roughness(0.070, 1.4, 0.2, 6)),
        0.75, look=Appearance((0.70, 0.68, 0.62), (0.45, 0.43, 0.39), 0.10, 2.0),
    ),
)  # fmt: skip

METALS = (
    Surface(
        "polished-steel", (Roughness(0.0020, 2.0, 0.1, 3),),
        0.45, 1.25, 12, look=Appearance((0.50, 0.51, 0.52), None, 0.006, gloss=0.15),
    ),
    Surface(
        "brushed-steel", (Roughness(0.007, 1.3, 0.4, 6, 16.0),),
        0.38, look=Appearance((0.46, 0.46, 0.47), None, 0.04, 2.0, 16.0, gloss=0.08),
    ),
    Surface(
        "aluminium-foil", (Roughness(0.040, 2.2, 0.03, 1.5), Roughness(0.003, 1.8, 0.3, 5)),
        0.40, stiffness_n_m=20000, look=Appearance((0.66, 0.67, 0.68), None, 0.03, 4.0, gloss=0.15),
    ),
    Surface(
        "hammered-copper", (Cells(5.5, -0.30, 0.03), Roughness(0.003, 1.8, 0.2, 4)),
        0.42, 1.2, look=Appearance((0.55, 0.25, 0.14), None, 0.05, 4.0, gloss=0.12),
    ),
    Surface(
        "perforated-metal", (Particles(0.04, 1.5, -0.45, 1.0, 0.10), Roughness(0.0035, 2.0, 0.2, 3)),
        0.40, 1.2, look=Appearance((0.48, 0.49, 0.50), (0.03, 0.03, 0.03), 0.01, gloss=0.12),
    ),
    Surface(
        "wire-mesh", (Weave(2.2, 0.60), Roughness(0.003, 2.0, 0.2, 3)),
        0.35, 1.15, look=Appearance((0.44, 0.45, 0.46), (0.02, 0.02, 0.02), 0.02, gloss=0.10),
    ),
    Surface(
        "tread-plate", (Particles(0.0024, 4.5, 1.4, 1.0), Roughness(0.010, 1.6, 0.2, 5)),
        0.45, look=Appearance((0.42, 0.43, 0.44), None, 0.06, 3.0, gloss=0.08),
    ),
    Surface(  # diamonds
        "knurled-metal", (Grating(1.2, 0.22, 30, 0.8), Grating(1.2, 0.22, 150, 0.8), Roughness(0.003, 1.8, 0.2, 4)),
        0.50, look=Appearance((0.38, 0.39, 0.40), (0.12, 0.12, 0.12), 0.02, gloss=0.08),
    ),
    Surface(  # single cut
        "metal-file", (Grating(0.8, 0.18, 25, 0.6), Roughness(0.004, 1.6, 0.3, 5)),
        0.75, 1.2, look=Appearance((0.28, 0.29, 0.30), (0.08, 0.08, 0.08), 0.02, gloss=0.06),
    ),
    Surface(
        "rusty-iron", (Roughness(0.055, 1.4, 0.15, 6), Particles(0.8, 0.5, 0.08, 0.0)),
        0.75, look=Appearance((0.30, 0.12, 0.05), (0.14, 0.06, 0.03), 0.35, 2.0),
    ),
    Surface(  # punched burrs
        "cheese-grater", (Particles(0.035, 1.2, 1.0, 1.0, 0.12), Roughness(0.003, 1.8, 0.2, 4)),
        0.45, 1.2, look=Appearance((0.50, 0.51, 0.52), None, 0.02, gloss=0.12),
    ),
)  # fmt: skip

DRAWN = (
    *FABRICS, *FLOORS, *PAPERS, *WOODS, *LEATHERS_AND_RUBBERS, *FOAMS, *PLASTICS, *STONES, *METALS
)  # fmt: skip


class Kind(NamedTuple):
    """Level and slope that the surfaces of a kind are set to, and the real materials that they are known from.

    Attributes
    ----------
    level_db : float
        Of a stylus at 120 mm/s and 1 N, 20 to 480 Hz, dB re 1 m/s^2.
    slope_db : float
        Of the spectrum's density, dB per octave.
    materials : int
        Real materials of that kind in one half of the Penn Haptic Texture Toolkit (Culbertson et al. 2014), whose mean,
        drawn towards that of all 60 by the weight of four more, this is.
    """

    level_db: float
    slope_db: float
    materials: int


KINDS: Mapping[str, Kind] = {
    "fabric": Kind(-2.2, -5.1, 14),
    "carpet": Kind(4.9, -6.5, 5),
    "paper": Kind(-1.6, -3.9, 16),
    "leather": Kind(-2.0, -5.7, 4),
    "foam": Kind(0.6, -4.9, 3),
    "plastic": Kind(0.1, -3.9, 8),
    "mineral": Kind(8.3, -2.2, 6),
    "metal": Kind(-0.1, -4.2, 3),
    "other": Kind(0.5, -4.5, 60),
}
"""The surfaces of ``other`` have the mean of all: of wood the half has a single material."""
RELIEF: Mapping[str, Mapping[str, tuple[float, float, float]]] = {
    "fabric": {
        "cotton-sheet": (0.0438, 0.0468, 4), "linen": (0.0199, 0.0448, 3.65), "denim": (0.0215, 0.0418, 3.75),
        "canvas": (0.0164, 0.0528, 3.8), "burlap": (0.0111, 0.0846, 4), "silk": (0.104, 0.0376, 4),
        "satin": (0.132, 0.0349, 4), "velvet": (0.0217, 0.132, 3.93), "corduroy": (0.0253, 0.0497, 4),
        "terry-towel": (0.0124, 0.105, 4), "wool-knit": (0.0136, 0.138, 4), "felt": (0.0154, 0.0817, 3.99),
        "fleece": (0.0196, 0.168, 4), "faux-fur": (0.0135, 0.313, 3.94), "microfibre-cloth": (0.0201, 0.0935, 3.91),
        "gauze": (0.0221, 0.103, 3.93), "nylon-webbing": (0.0276, 0.0251, 3.37), "suede": (0.0185, 0.0721, 3.94),
    },
    "carpet": {
        "loop-carpet": (0.0304, 0.135, 4), "shag-rug": (0.0157, 0.426, 4), "coir-doormat": (0.0088, 0.186, 4),
        "artificial-turf": (0.0147, 0.174, 4),
    },
    "paper": {
        "printer-paper": (0.139, 0.013, 2.77), "cardboard": (0.084, 0.0156, 2.88),
        "corrugated-cardboard": (0.128, 0.0199, 3.28), "paper-towel": (0.039, 0.0347, 3.01),
        "wallpaper": (0.0433, 0.0256, 3.09), "braille-page": (0.0247, 0.0387, 3.31),
        "plastic-film": (0.358, 0.0202, 3.59),
    },
    "leather": {
        "vinyl-flooring": (0.0776, 0.0497, 4), "smooth-leather": (0.105, 0.0428, 3.98),
        "grained-leather": (0.0447, 0.0723, 4),
    },
    "foam": {
        "yoga-mat": (0.05, 0.0628, 3.64), "kitchen-sponge": (0.0232, 0.171, 3.72),
        "scouring-pad": (0.0114, 0.0884, 3.62), "polystyrene-foam": (0.0465, 0.0559, 3.64),
        "foam-rubber": (0.0574, 0.122, 3.48),
    },
    "plastic": {
        "rubber-sheet": (0.137, 0.0223, 3.35), "ribbed-rubber-mat": (0.0325, 0.0371, 3.34),
        "silicone": (0.243, 0.0285, 3.44), "bubble-wrap": (0.359, 0.0479, 3.52),
        "smooth-plastic": (0.352, 0.0182, 3.22), "textured-plastic": (0.0387, 0.0267, 2.98),
        "studded-plastic": (0.00808, 0.0558, 3.27), "hair-comb": (0.0166, 0.0138, 2.25),
        "plastic-mesh": (0.0301, 0.0238, 2.69), "zip": (0.0245, 0.0169, 2.5), "glass": (0.666, 0.0142, 3.34),
        "frosted-glass": (0.0855, 0.0185, 2.93),
    },
    "mineral": {
        "fine-sandpaper": (0.0608, 0.0153, 2), "sandpaper": (0.0322, 0.0211, 2.13),
        "coarse-sandpaper": (0.0241, 0.0278, 2.28), "glazed-tiles": (0.117, 0.0466, 2.98),
        "terracotta": (0.108, 0.0228, 2.21), "polished-marble": (0.825, 0.0121, 2.37),
        "rough-granite": (0.0427, 0.0235, 2.16), "slate": (0.146, 0.0215, 2.43), "sandstone": (0.0346, 0.0276, 2.18),
        "concrete": (0.0436, 0.0288, 2.4), "brick": (0.0351, 0.0299, 2.22), "asphalt": (0.0203, 0.0346, 2.29),
        "plaster-wall": (0.153, 0.0173, 2.18), "roughcast": (0.0262, 0.0367, 2.32),
    },
    "metal": {
        "polished-steel": (0.375, 0.0123, 3.16), "brushed-steel": (0.0684, 0.0137, 2.81),
        "aluminium-foil": (0.0985, 0.0215, 3.27), "hammered-copper": (0.0363, 0.0392, 3.52),
        "perforated-metal": (0.0174, 0.0392, 3.35), "wire-mesh": (0.0138, 0.0371, 3.1),
        "tread-plate": (0.0657, 0.0209, 3.18), "knurled-metal": (0.0273, 0.0133, 2.55),
        "metal-file": (0.026, 0.0129, 2.56), "rusty-iron": (0.0165, 0.0251, 3.01),
        "cheese-grater": (0.0118, 0.0618, 3.51),
    },
    "other": {
        "straw-mat": (0.0453, 0.0276, 3.13), "bamboo-mat": (0.0475, 0.0232, 3.16),
        "polished-wood": (0.289, 0.0222, 3.38), "pine-board": (0.0638, 0.0348, 3.42), "oak": (0.0532, 0.0334, 3.26),
        "rough-sawn-wood": (0.0135, 0.0339, 3.16), "plywood": (0.0516, 0.0254, 3.23),
        "chipboard": (0.0412, 0.0277, 3.23), "tree-bark": (0.0114, 0.0557, 3.3), "cork": (0.034, 0.0478, 3.55),
    },
}  # fmt: skip
"""Of each surface of a kind the share of its heights that is felt, and the rms, mm, and beta of the ground besides:
written by ``python -m benchmarks.set_everyday``."""


def as_measured(surface: Surface, felt: float, rms_mm: float, beta: float) -> Surface:
    """Return a surface of which a share is felt, and of a ground besides: the spectra of real materials are smooth."""
    return replace(surface, felt=felt, ground=Roughness(rms_mm, beta, 0.05, 8.0))


_FELT = {name: felt for members in RELIEF.values() for name, felt in members.items()}
EVERYDAY = tuple(as_measured(surface, *_FELT[surface.name]) for surface in DRAWN)


def known_from(name: str) -> str:
    """Return what an everyday surface was set from, in words."""
    kind = next(kind for kind, members in RELIEF.items() if name in members)
    of = "all kinds" if kind == "other" else f"the kind {kind}"
    return (
        f"level and slope of the spectrum from the mean of {KINDS[kind].materials} real materials of {of} "
        "(Penn Haptic Texture Toolkit); dimensions of its structure are plausible, not measured"
    )


SYNONYMS = {
    "cotton-sheet": ("bed sheet", "shirt", "pillowcase"),
    "denim": ("jeans",),
    "canvas": ("tent", "sail", "tarpaulin"),
    "burlap": ("jute sack", "hessian"),
    "silk": ("scarf", "tie"),
    "satin": ("ribbon", "lining"),
    "terry-towel": ("bath towel", "bathrobe"),
    "wool-knit": ("jumper", "knitted pullover", "sock"),
    "felt": ("pool table",),
    "faux-fur": ("animal fur", "plush toy", "teddy bear"),
    "microfibre-cloth": ("cleaning cloth",),
    "gauze": ("bandage", "net curtain"),
    "nylon-webbing": ("strap", "seat belt"),
    "loop-carpet": ("rug",),
    "artificial-turf": ("grass", "lawn", "football pitch"),
    "straw-mat": ("tatami", "wicker basket", "rattan"),
    "vinyl-flooring": ("linoleum",),
    "printer-paper": ("page of a book", "envelope", "newspaper"),
    "cardboard": ("carton", "parcel"),
    "paper-towel": ("kitchen roll", "napkin", "tissue"),
    "polished-wood": ("parquet", "table top", "varnished wood", "piano"),
    "pine-board": ("wooden plank", "shelf"),
    "rough-sawn-wood": ("fence", "pallet", "splintered timber"),
    "chipboard": ("pressed wood panel",),
    "smooth-leather": ("wallet", "leather shoe", "handbag"),
    "grained-leather": ("sofa", "steering wheel"),
    "rubber-sheet": ("tyre", "inner tube", "balloon"),
    "silicone": ("baking mould", "phone case"),
    "scouring-pad": ("steel wool", "abrasive fleece"),
    "polystyrene-foam": ("styrofoam", "packing foam"),
    "foam-rubber": ("mattress", "cushion"),
    "smooth-plastic": ("phone screen", "keyboard key", "acrylic"),
    "textured-plastic": ("dashboard", "computer housing"),
    "studded-plastic": ("lego", "building bricks", "toy blocks"),
    "hair-comb": ("radiator grille", "washboard"),
    "plastic-mesh": ("laundry basket", "insect screen"),
    "zip": ("zipper",),
    "plastic-film": ("plastic bag", "cling film", "cellophane"),
    "glass": ("window", "mirror", "bottle", "ice"),
    "frosted-glass": ("bathroom window", "touchpad"),
    "glazed-tiles": ("bathroom wall", "porcelain", "ceramic tile"),
    "terracotta": ("flower pot", "unglazed clay", "roof tile"),
    "polished-marble": ("marble counter", "stone floor"),
    "slate": ("chalkboard", "roof shingle"),
    "concrete": ("pavement", "cement", "car park"),
    "asphalt": ("road", "tarmac", "street"),
    "plaster-wall": ("painted wall", "gypsum", "ceiling"),
    "roughcast": ("stucco", "facade", "pebble dash"),
    "polished-steel": ("knife blade", "cutlery", "chrome"),
    "brushed-steel": ("fridge door", "stainless steel", "laptop lid"),
    "aluminium-foil": ("tin foil", "chocolate wrapper"),
    "hammered-copper": ("brass pot",),
    "perforated-metal": ("colander", "speaker grille"),
    "wire-mesh": ("sieve", "chain-link fence", "chain mail"),
    "tread-plate": ("metal stairs", "checker plate"),
    "knurled-metal": ("barbell", "dial", "screwdriver handle"),
    "metal-file": ("rasp", "saw blade"),
    "rusty-iron": ("rust", "scrap metal"),
}
"""Other names and typical objects of the surfaces."""
