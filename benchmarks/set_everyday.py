"""Set the everyday surfaces to the levels and slopes of their kinds: ``python -m benchmarks.set_everyday``.

A stylus strokes each at 120 mm/s and 1 N; heights are scaled and the roughness bent until the spectrum has the level
and slope of its kind, plus `OWN` of what distinguishes the surface from its kind as drawn. Prints `RELIEF` of
`tactogram.datasets.simulate.everyday`.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np

from benchmarks.experiments.real_surfaces import band_levels, levels, slopes, spectrum_of
from tactogram.datasets.simulate import everyday, sets
from tactogram.datasets.simulate.stroke import RecordingTask

OWN = 0.25
ROUNDS, TAKES = 4, 2
STEEPEST = 1.0, 4.0
"""Range of the roughness's beta."""


def figures(number, relief):
    """Return level and slope of a surface with a factor and a bend."""
    everyday._FELT[everyday._DRAWN[number].name] = relief
    surface = everyday._as_measured(everyday._DRAWN[number])
    facts = sets.SETS["everyday"]
    drawn = replace(
        facts, surfaces=tuple(surface if n == number else s for n, s in enumerate(everyday._DRAWN))
    )
    sets.SETS = {**sets.SETS, "everyday": drawn}
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
    names = [surface.name for surface in everyday._DRAWN]
    kinds = [next(kind for kind, members in everyday.RELIEF.items() if name in members) for name in names]
    relief = [(1.0, 0.0)] * len(names)
    with ProcessPoolExecutor() as pool:
        found = np.array(list(pool.map(figures, range(len(names)), relief)))
        targets = np.empty_like(found)
        for kind, (level, slope, _) in everyday.KINDS.items():
            own = np.array([each == kind for each in kinds])
            targets[own] = (level, slope) + OWN * (found[own] - found[own].mean(0))
        for _ in range(ROUNDS):
            relief = [
                stepped(surface, was, *wanted)
                for surface, was, wanted in zip(everyday._DRAWN, relief, targets - found, strict=True)
            ]
            found = np.array(list(pool.map(figures, range(len(names)), relief)))
    rows = list(zip(names, kinds, relief, targets - found, strict=True))
    for kind in everyday.KINDS:
        print(f'    "{kind}": {{')
        for name, of, (factor, steeper), missed in rows:
            if of == kind:
                print(
                    f'        "{name}": ({factor:.3g}, {steeper:.2f}),  # {missed[0]:+.1f} dB {missed[1]:+.1f}'
                )
        print("    },")


def stepped(surface, was, level, slope):
    """Return the next factor and bend of a surface that lacks so much of its level and slope."""
    betas = [t.beta for t in surface.textures if isinstance(t, everyday.Roughness)]
    bend = was[1] - 0.25 * np.clip(slope, -4, 4)
    bend = float(np.clip(bend, STEEPEST[0] - min(betas), STEEPEST[1] - max(betas))) if betas else 0.0
    return float(was[0] * 10 ** (np.clip(level, -20, 20) / 20)), bend


if __name__ == "__main__":
    main()
