"""Phase gradient heap integration: phase from magnitude without iteration.

Průša, Balazs & Søndergaard, "A noniterative method for reconstruction of phase from STFT magnitude",
IEEE/ACM Trans. Audio, Speech, Lang. Process. 25(5), 2017.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import get_window
from torch import Tensor

from tactogram.features.stft import STFT, Window


def gradient_phase(magnitude: Tensor, transform: STFT, *, seed: int = 0, tolerance: float = 1e-6) -> Tensor:
    """Return the phase of ``magnitude`` as if its window were a Gaussian (the paper's algorithm 1).

    Two details are ours. A real signal's magnitude is even about 0 Hz and half the rate, so the frequency derivative
    uses that mirror image: without it the phase at 0 Hz drifts, and signals with most of their energy there are
    recovered worse (by 6 to 25 dB on rectified sensor recordings). And next to bins below ``tolerance`` the difference
    is one-sided, so that ignored bins do not distort the phase of their neighbours.

    ``magnitude`` is of ``transform``, >= 0, shape (batch, frame, bin): bins run fastest, unlike in `STFT`. Magnitudes
    up to ``tolerance``, as a share of an item's greatest, get a random phase, the same for every item. Returns radians,
    float64, of the same shape, on the processor.
    """
    n_fft, hop = transform.n_fft, transform.hop
    gamma = window_gamma(transform.window, n_fft)
    size = magnitude.detach().cpu().double()
    sure = size > tolerance * size.amax((1, 2), keepdim=True)
    log = torch.where(sure, size, 1).log()
    last = 1 if n_fft % 2 == 0 else 0
    mirrored = torch.cat([log[..., 1:2], log, log[..., -1 - last : log.shape[-1] - last]], -1)
    mirrored_sure = torch.cat([sure[..., 1:2], sure, sure[..., -1 - last : log.shape[-1] - last]], -1)
    over_bins = _difference(mirrored, mirrored_sure, -1)
    over_frames = torch.nn.functional.pad(log, (0, 0, 1, 1))
    over_frames = _difference(over_frames, torch.nn.functional.pad(sure, (0, 0, 1, 1)), 1)
    # Steps of the phase from frame to frame and from bin to bin: its partial derivatives follow from those of
    # the log magnitude (Sec. III). The second has its last term because the transform counts time from a frame's
    # first sample, not from its centre.
    bins = torch.arange(log.shape[-1], dtype=torch.float64)
    along_time = over_bins * (hop * n_fft / gamma) + 2 * math.pi * hop / n_fft * bins
    along_bins = over_frames * (-gamma / (hop * n_fft)) - 2 * math.pi * (n_fft // 2) / n_fft
    random = torch.Generator().manual_seed(seed)
    start = 2 * math.pi * torch.rand(log.shape[1:], generator=random, dtype=torch.float64)
    phase = start.expand(log.shape).clone()
    for k in range(len(phase)):
        order = np.argsort(-size[k].float().numpy().ravel()).astype(np.int64)
        _integrate(
            size[k].numpy(), along_time[k].numpy(), along_bins[k].numpy(),
            (~sure[k]).numpy(), order, phase[k].numpy(),
        )  # fmt: skip
    return phase


@lru_cache(maxsize=64)
def window_gamma(window: Window, n_fft: int) -> float:
    """Return gamma, in samples squared, of the Gaussian exp(-pi l^2 / gamma) nearest to ``window``.

    Nearest in the least-squares sense. Within 2 % of the constants of the authors' toolbox for Hann
    (0.25645 n_fft^2), Hamming (0.29794) and Blackman (0.17954).
    """
    values = get_window(window, n_fft)
    time = np.arange(n_fft) - n_fft / 2

    def distance(share: float) -> float:
        gaussian = np.exp(-np.pi * time**2 / (share * n_fft**2))
        return float(np.sum((values / values.max() - gaussian) ** 2))

    return float(minimize_scalar(distance, bounds=(1e-3, 4), method="bounded").x) * n_fft**2


def _difference(log: Tensor, sure: Tensor, dim: int) -> Tensor:
    """Return the mean difference to the sure neighbours; two shorter along ``dim``."""
    n = log.shape[dim]
    before, here, after = (log.narrow(dim, k, n - 2) for k in range(3))
    has_before, _, has_after = (sure.narrow(dim, k, n - 2).double() for k in range(3))
    steps = (here - before) * has_before + (after - here) * has_after
    return steps / (has_before + has_after).clamp_min(1)


@njit(cache=True, nogil=True)
def _integrate(
    size: NDArray[np.float64],
    along_time: NDArray[np.float64],
    along_bins: NDArray[np.float64],
    done: NDArray[np.bool_],
    order: NDArray[np.int64],
    phase: NDArray[Any],
) -> None:
    """Fill ``phase`` (frame, bin) in place, from the greatest magnitude outwards, where not ``done``.

    A max-heap on magnitude holds the border of the integrated area; each island that it does not reach starts at
    phase 0.
    """
    frames, bins = size.shape
    heap = np.empty(size.size, np.int64)
    for first in order:
        if done.flat[first]:
            continue
        done.flat[first] = True
        phase.flat[first] = 0.0
        heap[0] = first
        count = 1
        while count > 0:
            here = heap[0]
            count -= 1
            _sift_down(heap, count, heap[count], size)
            t, m = here // bins, here % bins
            for side in range(4):
                u, k = t, m
                if side == 0:
                    u += 1
                elif side == 1:
                    u -= 1
                elif side == 2:
                    k += 1
                else:
                    k -= 1
                if u < 0 or u >= frames or k < 0 or k >= bins or done[u, k]:
                    continue
                if u != t:
                    step = 0.5 * (u - t) * (along_time[t, m] + along_time[u, k])
                else:
                    step = 0.5 * (k - m) * (along_bins[t, m] + along_bins[u, k])
                phase[u, k] = phase[t, m] + step
                done[u, k] = True
                _sift_up(heap, count, u * bins + k, size)
                count += 1


@njit(cache=True, nogil=True)
def _sift_down(heap: NDArray[np.int64], count: int, item: int, size: NDArray[np.float64]) -> None:
    """Put ``item`` at the root of the first ``count`` places and let it sink."""
    place = 0
    child = 1
    while child < count:
        if child + 1 < count and size.flat[heap[child + 1]] > size.flat[heap[child]]:
            child += 1
        if size.flat[heap[child]] <= size.flat[item]:
            break
        heap[place] = heap[child]
        place = child
        child = 2 * place + 1
    heap[place] = item


@njit(cache=True, nogil=True)
def _sift_up(heap: NDArray[np.int64], place: int, item: int, size: NDArray[np.float64]) -> None:
    """Put ``item`` at ``place`` and let it rise."""
    while place > 0:
        parent = (place - 1) // 2
        if size.flat[heap[parent]] >= size.flat[item]:
            break
        heap[place] = heap[parent]
        place = parent
    heap[place] = item
