"""Downstream accuracy: a classifier trained on generated signals and tested on real ones, and the reverse."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.intervals import Accuracy, wilson
from tactogram.evaluation.measures.measure import check_alike, stacks
from tactogram.evaluation.measures.spectra import (
    SEGMENT_S,
    SILENT,
    band_edges,
    band_sums,
    envelopes,
    felt_edges,
    modulation_power,
)
from tactogram.signal import Signal
from tactogram.signal.perception import FELT_HZ

Classify = Callable[[Sequence[Signal]], Sequence[str]]
"""A trained classifier: the label of each signal."""

Fit = Callable[[Sequence[Signal], Sequence[str]], Classify]
"""Trains a classifier on signals and their labels."""


def transfer_accuracy(
    trained: Mapping[str, Sequence[Signal]], tested: Mapping[str, Sequence[Signal]], *, fit: Fit | None = None
) -> Accuracy:
    """Return the accuracy of a classifier trained on one set and tested on another.

    ``transfer_accuracy(made, real)`` is *trained on generated, tested on real*: it drops where generated signals lack
    or confuse features of a texture. ``transfer_accuracy(real, made)`` is the reverse: whether each
    generated signal is classified as its own material. Real against other real is the floor of both. Missing
    variety lowers the first and not the second: read both.

    All signals have one rate, unit and set of axes and are cut alike (`segments`); every material of ``tested`` is in
    ``trained``, which has two or more. ``fit`` is `linear_discriminant` by default.

    The accuracy is the mean over materials of the share classified correctly. Wilson's 95 % interval assumes that the
    signals of ``tested`` are independent: pieces of one recording are not.

    References
    ----------
    C. Esteban, S. L. Hyland, G. Rätsch, "Real-valued (medical) time series generation with recurrent conditional
    GANs", 2017, arXiv:1706.02633: TSTR and TRTS.
    """
    untrained = sorted(set(tested) - set(trained))
    if len(trained) < 2 or not tested or untrained:
        raise ParameterError.must(
            "trained",
            "hold at least two materials and all of tested",
            ", ".join(sorted(trained)) or "none",
            remedy=f"lacks {', '.join(untrained) or 'none'}",
        )
    check_alike(*trained.values(), *tested.values())
    signals = [signal for members in trained.values() for signal in members]
    labels = [name for name, members in trained.items() for _ in members]
    classify = (fit or linear_discriminant)(signals, labels)
    shares = [
        float(np.mean([answer == name for answer in classify(members)])) for name, members in tested.items()
    ]
    return wilson(float(np.mean(shares)), sum(len(members) for members in tested.values()))


def linear_discriminant(signals: Sequence[Signal], labels: Sequence[str]) -> Classify:
    """Train a linear discriminant on `classifier_features`: quick, without settings, and hard to beat.

    Signals of one kind, at least 0.25 s long, with two or more different labels.

    References
    ----------
    The shared covariance is shrunk as in O. Ledoit, M. Wolf, J. Multivar. Anal. 88 (2004) 365-411.
    """
    features = classifier_features(signals)
    centre, scale = features.mean(axis=0), features.std(axis=0)
    scale[scale == 0] = 1.0

    model = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto")
    model.fit((features - centre) / scale, np.asarray(labels))

    def classify(others: Sequence[Signal]) -> Sequence[str]:
        check_alike(signals, others)
        return [str(name) for name in model.predict((classifier_features(others) - centre) / scale)]

    return classify


def classifier_features(signals: Sequence[Signal]) -> NDArray[np.float64]:
    """Return the features of a quick classifier: blind to phase, sensitive to level.

    float64, shape (signal, feature), of signals of one kind, at least 0.25 s long. Per axis: level in third octaves of
    20-1000 Hz, dB, and the fluctuation of the envelope of that band in octaves of 4-64 Hz, dB re an envelope's mean
    square (see `envelope_spectrum_distance`).
    """
    kind = check_alike(signals, shortest_s=SEGMENT_S)
    edges = felt_edges(kind.rate)
    modulations = band_edges(4.0, 64.0, per_octave=1)
    rows = []
    for x in stacks(signals):
        frequency, power = welch(x, kind.rate, nperseg=round(SEGMENT_S * kind.rate), axis=-1)
        levels = band_sums(power, frequency, edges) * frequency[1]
        envelope, rate = envelopes(x, kind.rate, *FELT_HZ, np.ones_like)
        fluctuation = modulation_power(envelope, rate, 1.0, modulations)
        both = np.concatenate([np.maximum(levels, SILENT), np.maximum(fluctuation, 1e-4)], axis=-1)
        rows.append(10 * np.log10(both).reshape(len(x), -1))
    lengths = [len(signal) for signal in signals]
    stacked = [k for length in dict.fromkeys(lengths) for k, own in enumerate(lengths) if own == length]
    features = np.concatenate(rows)
    return np.asarray(features[np.argsort(stacked)])
