"""A measure of seams between joined pieces."""

import numpy as np


def seam_excess_db(signal, places):
    """Return the excess of the jumps to the samples at ``places`` over those elsewhere, dB, averaged over the axes."""
    jumps = np.diff(signal.samples.astype(np.float64), axis=1) ** 2
    at = np.isin(np.arange(1, len(signal)), places)
    excess = jumps[:, at].mean(axis=1) / jumps[:, ~at].mean(axis=1)
    return 10 * np.log10(max(excess.mean(), 1e-30))
