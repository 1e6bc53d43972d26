"""Rule from touch to words: cues from 0 to 1 out of physical quantities, and ten words out of the cues.

Simulated; docs/simulated-raters.md gives the source of each part. Nothing here depends on a stimulus's name.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.datasets.ratings.words import WORDS
from tactogram.datasets.simulate.touch import RATE, FingerSlide
from tactogram.signal.perception import weighted

PACINIAN_HZ = (40.0, 1000.0)
FLUTTER_HZ = (2.0, 40.0)


@dataclass(frozen=True)
class TouchCues:
    """Tactile cues, each 0 to 1 except the level.

    The level is that of the whole second, unlike `tactogram.signal.perception.sensation_level_db`, which weighs the
    middle: a loop has none.
    """

    level_db: (
        float  # of the vibration above 40 Hz over the threshold of touch: 0 is a barely perceptible sine
    )
    fine: float  # pitch: 1 for content well above 150 Hz, 0 well below
    irregular: float  # number of spectral lines: 0 one sine, 1 noise
    impulsive: float  # dominance of single jolts: kurtosis 0 is 0, 60 is 1
    flutter: float  # slow movement of the skin, 2 to 40 Hz: 1 um is 0, 100 um is 1
    coarse: float  # relief that presses into the skin: 0.15 mm rms is 1
    steep: float  # slopes of the relief: 0.6 rms is 1
    friction: float  # a coefficient of 0.25 is 0, of 0.75 is 1
    catching: float  # slow variation of the friction: 0.15 rms is 1


def touch_cues(touched: FingerSlide) -> TouchCues:
    """Return the cues of a touch."""
    felt = weighted(touched.skin, band=PACINIAN_HZ).samples.astype(np.float64)
    frequency, power = scipy.signal.periodogram(felt, RATE)
    total = power.sum(0)
    share = total / max(float(total.sum()), 1e-12)
    lines = float(np.exp(-(share * np.log(share + 1e-12)).sum()))
    mean_hz = float((share * frequency).sum())
    slow, drag = (_slow(x) for x in (touched.skin.samples.astype(np.float64), touched.drag[None]))
    jolts = float(scipy.stats.kurtosis(felt[0])) if felt[0].std() > 0 else 0.0
    return TouchCues(
        level_db=float(10 * np.log10(max(2 * np.mean(felt**2, axis=1).sum(), 1e-10))),
        fine=float(1 / (1 + np.exp(-(mean_hz - 150) / 35))),
        irregular=clip(np.log(lines) / np.log(200)),
        impulsive=clip(np.log1p(max(jolts, 0.0)) / np.log(61)),
        flutter=clip(np.log10(max(1e6 * slow, 1e-3)) / 2),
        coarse=clip(touched.relief_mm / 0.15),
        steep=clip(touched.steepness / 0.6),
        friction=clip((touched.friction - 0.25) / 0.5),
        catching=clip(drag / 0.15),
    )


def vibration_felt(level_db: float) -> float:
    """Return the perceived strength of a vibration: 5 dB below threshold is 0, 40 dB above is 1."""
    return clip((level_db + 5) / 45)


def touch_words(cues: TouchCues, *, sensitivity_db: float = 0.0) -> NDArray[np.float64]:
    """Return the score of each word, 0 to 1, float64, shape (word,), in the order of `WORDS`.

    ``sensitivity_db`` is that of a person above the mean.
    """
    c = cues
    vibration = vibration_felt(c.level_db + sensitivity_db)
    smooth = (1 - vibration) * (1 - 0.75 * c.coarse)
    middling = float(np.exp(-(((vibration - 0.35) / 0.22) ** 2)))
    words = {
        "dry": 0.08 + 0.8 * middling * (0.3 + 0.7 * c.fine) * (1 - 0.8 * c.coarse) * (1 - 0.7 * c.friction),
        "sleek": 0.03 + 0.85 * smooth * (1 - 0.45 * c.friction) * (1 - 0.5 * c.flutter),
        "slippery": 0.03 + 0.9 * smooth**1.3 * (1 - 0.6 * c.friction) * (1 - 0.6 * c.catching),
        "rugged": 0.03 + 0.8 * c.coarse * (0.35 + 0.65 * vibration) + 0.22 * c.flutter * vibration,
        "uneven": 0.03 + 0.75 * c.coarse + 0.30 * c.flutter,
        "rough": 0.03 + 0.85 * vibration * (0.55 + 0.45 * c.irregular) + 0.15 * c.coarse * c.steep,
        "squishy": 0.04 + 0.25 * c.flutter * (1 - c.coarse) + 0.10 * c.friction,
        "prickle": 0.03 + vibration * (0.25 * c.fine + 0.45 * c.impulsive + 0.45 * c.steep),
        "sticky": 0.03 + 0.65 * c.friction**1.2 * (1 - 0.5 * vibration) + 0.30 * c.catching,
        "rustle": 0.03 + 0.8 * vibration * c.irregular * (0.45 + 0.35 * c.coarse + 0.35 * c.impulsive),
    }
    return np.asarray(np.clip([words[word] for word in WORDS], 0.0, 1.0))


def _slow(x: NDArray[np.float64]) -> float:
    """Return the rms in `FLUTTER_HZ` of all rows together."""
    frequency, power = scipy.signal.periodogram(x, RATE)
    kept = (frequency >= FLUTTER_HZ[0]) & (frequency < FLUTTER_HZ[1])
    return float(np.sqrt(power[:, kept].sum() * (frequency[1] - frequency[0])))


def clip(x: float) -> float:
    """Return ``x`` limited to 0 to 1."""
    return float(np.clip(x, 0.0, 1.0))
