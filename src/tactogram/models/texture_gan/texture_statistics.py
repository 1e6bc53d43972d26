"""Texture statistics that do not depend on phase, and a distance between two sets of them.

As in work on hearing textures: marginal distributions, envelopes of bands, their modulation and correlations
(McDermott & Simoncelli 2011).

References
----------
- McDermott, J. H. & Simoncelli, E. P. (2011). Sound texture perception via statistics of the auditory
  periphery: evidence from sound synthesis. Neuron 71(5), 926-940. doi 10.1016/j.neuron.2011.06.032
- Gneiting, T. & Raftery, A. E. (2007). Strictly proper scoring rules, prediction, and estimation. J. Am. Stat.
  Assoc. 102(477), 359-378. Sec. 4.3. doi 10.1198/016214506000001437
- Gritsenko, A. et al. (2020). A spectral energy distance for parallel speech synthesis. NeurIPS 33.
"""

from __future__ import annotations

import math
from itertools import pairwise

import torch
from torch import Tensor

QUANTILES = (0.002, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 0.998)
RANKED = 1024
"""Fewest samples of a signal that its quantiles are computed from."""
SIZES = (32, 128)
"""Samples of the two short-time spectra; each hops by a quarter."""
BANDS = 5
FLOOR = 1e-3
"""Power, relative to that of white noise of unit variance, below which a band counts as silent: -30 dB."""


def statistics(x: Tensor) -> Tensor:
    """Return the statistics of signals, (batch, axis, time) -> float32, (batch, statistic).

    Signals have about unit variance and at least 512 samples.
    """
    x = x.float()
    subset = x[:, :, :: max(1, x.shape[2] // RANKED)]
    ranks = torch.tensor(QUANTILES, device=x.device) * (subset.shape[2] - 1)
    parts = [torch.asinh(subset.sort(dim=2).values[:, :, ranks.long()]).flatten(1)]
    for size in SIZES:
        spectrum = _spectrum(x, size)  # B, A, F, N
        envelopes = _envelopes(spectrum)  # B, A BANDS, N
        mean = envelopes.mean(2, keepdim=True)
        swing = envelopes - mean
        deviation = swing.square().mean(2, keepdim=True).add(1e-4).sqrt()
        shape = swing / deviation
        parts += [mean.flatten(1), deviation.log().flatten(1), shape.pow(3).mean(2)]
        together = shape @ shape.transpose(1, 2) / shape.shape[2]  # B, A BANDS, A BANDS
        row, column = torch.triu_indices(together.shape[1], together.shape[2], offset=1)
        parts += [together[:, row, column], _modulation(swing).flatten(1)]
        if x.shape[1] > 1:
            parts.append(_coherency(spectrum))
    return torch.cat(parts, 1)


def spread_within(found: Tensor, classes: Tensor) -> Tensor:
    """Return the deviation of each statistic, (signal, statistic), within the classes, (signal,): (statistic,)."""
    variances = [found[classes == k].var(0, correction=0) for k in sorted(set(classes.tolist()))]
    return torch.stack(variances).mean(0).sqrt().clamp(min=1e-3)


def energy_distance(real: Tensor, made: Tensor, again: Tensor) -> Tensor:
    """Return an unbiased estimate of the energy distance between the processes behind ``real`` and the rest.

    ``mean(2 |real - made| - |made - again|)``, omitting what only depends on ``real``: least when the distributions
    are the same (Gneiting & Raftery 2007, Eq. 21; Gritsenko et al. 2020). Row k of each, shape
    (batch, statistic), is of one condition; ``again`` is drawn like ``made``, independently.
    """
    distance = torch.linalg.vector_norm
    near = distance(real - made, dim=1) + distance(real - again, dim=1)
    result: Tensor = (near - distance(made - again, dim=1)).mean() / math.sqrt(real.shape[1])
    return result


def _spectrum(x: Tensor, size: int) -> Tensor:
    """Return the short-time spectrum, complex64, (batch, axis, frequency, frame); 1 in power for white noise."""
    window = torch.hann_window(size, device=x.device)
    spectrum: Tensor = torch.stft(
        x.flatten(0, 1), size, size // 4, window=window, center=False, return_complex=True
    )
    spectrum = spectrum / window.square().sum().sqrt()
    return spectrum.view(x.shape[0], x.shape[1], *spectrum.shape[1:])


def _envelopes(spectrum: Tensor) -> Tensor:
    """Return log band power over time: (batch, axis * band, frame)."""
    power = spectrum.real.square() + spectrum.imag.square()
    bands = torch.stack([power[:, :, low:high].mean(2) for low, high in _edges(power.shape[2], BANDS)], 2)
    return (bands + FLOOR).log().flatten(1, 2)


def _coherency(spectrum: Tensor) -> Tensor:
    """Return the coherency of each pair of axes in each band, real and imaginary part: (batch, 2 * pair * band)."""
    first, second = torch.triu_indices(spectrum.shape[1], spectrum.shape[1], offset=1)
    parts = []
    for low, high in _edges(spectrum.shape[2], BANDS):
        band = spectrum[:, :, low:high].flatten(2)  # B, A, F N
        cross = band @ band.mH  # B, A, A
        power = cross.diagonal(dim1=1, dim2=2).real + FLOOR * band.shape[2]  # B, A
        parts.append(cross[:, first, second] / (power[:, first] * power[:, second]).sqrt())
    coherency: Tensor = torch.view_as_real(torch.cat(parts, 1)).flatten(1)
    return coherency


def _modulation(swing: Tensor) -> Tensor:
    """Return the log power of envelopes in half octaves of modulation frequency: (batch, envelope, band)."""
    frames = swing.shape[2]
    window = torch.hann_window(frames, device=swing.device)
    power = torch.fft.rfft(swing * window).abs().square() / window.square().sum()
    bands = _edges(power.shape[2], 2 * int(math.log2(frames)), per_octave=2)
    levels = [(power[:, :, low:high].mean(2) + 1e-3).log() for low, high in bands]
    return torch.stack(levels, 2)


def _edges(bins: int, bands: int, *, per_octave: int = 1) -> list[tuple[int, int]]:
    """Return first and last bin (exclusive) of bands that widen towards the top; none is empty, no bin twice."""
    tops = sorted({max(1, round((bins - 1) / 2 ** (k / per_octave))) for k in range(bands)})
    return [(low + 1, high + 1) for low, high in pairwise((0, *tops))]
