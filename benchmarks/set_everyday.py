"""Set the everyday surfaces to the levels and slopes of their kinds: ``python -m benchmarks.set_everyday``.

A stylus strokes each at 120 mm/s and 1 N. Of its invented structure so much is felt that it is `STRUCTURE_DB` weaker
than the whole, or `RIBS_DB` if it has high ribs; the rest is a ground, whose height and beta are changed until the
spectrum has the level and slope of its kind, plus `OWN` of what distinguishes the surface from its kind as drawn.
Prints the columns ``felt``, ``ground_rms_mm`` and ``ground_beta`` of ``surfaces.csv``.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from benchmarks.experiments.real_surfaces import band_levels, levels, slopes, spectrum_of
from tactogram.datasets.everyday import KIND_OF
from tactogram_simulate import materials, sets
from tactogram_simulate.stroke import RecordingTask
from tactogram_simulate.surfaces import Grating

OWN = 0.25
STRUCTURE_DB = 10.0
"""Chosen from 3, 6 and 10 on half of the real materials; without any structure they are nearer still."""
RIBS_DB, RIB_HEIGHT = 3.0, 0.12
"""Of gratings whose height is at least such a share of their period, which hardly any of these materials has."""
ROUNDS, TAKES = 6, 2
FLATTEST, STEEPEST = 1.0, 4.0
"""Range of the ground's beta."""


def figures(number, felt, rms_mm=0.0, beta=3.0):
    """Return level and slope of a surface of whose structure a share is felt, and a ground."""
    drawn = list(materials.DRAWN)
    drawn[number] = materials.as_measured(drawn[number], felt, rms_mm, beta)
    sets.SETS = {**sets.SETS, "everyday": replace(sets.SETS["everyday"], surfaces=tuple(drawn))}
    bands = []
    for take in range(TAKES):
        task = RecordingTask("everyday", 5, number, "stylus", 120.0, take, 2.0, 2500.0, 1.0, own_image=False)
        signal = sets.make(task).streams["acceleration"]
        still = signal.with_samples(signal.samples - signal.samples.mean(1, keepdims=True))
        bands.append(band_levels(spectrum_of(still)))
    mean = np.mean(bands, 0)
    return float(levels(mean)), float(slopes(mean))


def main():
    """Print the table."""
    names = [surface.name for surface in materials.DRAWN]
    kinds = [KIND_OF[name] for name in names]
    felt, rms_mm, beta = (np.full(len(names), value) for value in (1.0, 0.03, 3.0))
    with ProcessPoolExecutor() as pool:

        def measured(*columns):
            return np.array(list(pool.map(figures, range(len(names)), *columns)))

        found = measured(felt)
        targets = np.empty_like(found)
        for kind, (level, slope) in materials.KINDS.items():
            own = np.array([each == kind for each in kinds])
            targets[own] = (level, slope) + OWN * (found[own] - found[own].mean(0))
        weaker = np.array([RIBS_DB if ribbed(surface) else STRUCTURE_DB for surface in materials.DRAWN])
        felt = louder(felt, targets[:, 0] - found[:, 0])
        for _ in range(2):
            felt = louder(felt, targets[:, 0] - measured(felt)[:, 0] - weaker)
        for number in range(ROUNDS):
            if number:
                lacking = targets - found
                rms_mm = louder(rms_mm, lacking[:, 0])
                beta = np.clip(beta - 0.25 * np.clip(lacking[:, 1], -4, 4), FLATTEST, STEEPEST)
            found = measured(felt, rms_mm, beta)
    for row in zip(names, kinds, felt, rms_mm, beta, *(targets - found).T, strict=True):
        print("{},{},{:.3g},{:.3g},{:.3g}  # {:+.1f} dB {:+.1f}".format(*row))


def ribbed(surface):
    """Return whether a surface has high ribs."""
    first = surface.textures[0]
    return isinstance(first, Grating) and first.height_mm > RIB_HEIGHT * first.period_mm


def louder(heights, gain_db):
    """Return heights that are felt as so much stronger."""
    return heights * 10 ** (np.clip(gain_db, -20, 20) / 20)


if __name__ == "__main__":
    main()
