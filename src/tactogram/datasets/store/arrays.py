"""Store as arrays: samples, labels and groups, as scikit-learn and PyTorch take them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.recording import RecordingInfo
from tactogram.errors import ParameterError
from tactogram.signal import Signal


class StoreArrays(NamedTuple):
    """Samples, labels and groups of the recordings of a store, in its order."""

    X: NDArray[np.float32]
    """Shape (recording, axis, time)."""
    y: NDArray[np.str_]
    """Material of each, shape (recording,); "" where unknown."""
    groups: NDArray[np.str_]
    """What must not be divided between training and test, shape (recording,)."""


def stacked(infos: Sequence[RecordingInfo], signals: Sequence[Signal], by: str) -> StoreArrays:
    """Return signals of one length, each of a recording, as arrays; see `Store.to_numpy`."""
    if len(kinds := sorted({(signal.rate, signal.axes) for signal in signals})) > 1:
        told = "; ".join(f"{rate:g} of {','.join(axes)}" for rate, axes in kinds)
        raise ParameterError.must("recordings", f"have one rate and the same axes, got {told}")
    groups = [getattr(info, by) for info in infos]
    return StoreArrays(
        np.stack([signal.samples for signal in signals]),
        np.array([info.material or "" for info in infos]),
        np.array(
            [info.id if group is None else str(group) for info, group in zip(infos, groups, strict=True)]
        ),
    )


def common_lengths(held: Sequence[int], rates: Sequence[float], seconds: float | None) -> list[int]:
    """Return the number of samples to take of each recording, which has ``held`` at its rate."""
    lasting = [count / rate for count, rate in zip(held, rates, strict=True)]
    if seconds is None:
        if len(set(held)) > 1:
            raise ParameterError(
                f"recordings last {min(lasting):g} to {max(lasting):g} s; choose seconds, {min(lasting):g} at most"
            )
        return list(held)
    if not 0 < seconds <= min(lasting) * (1 + 1e-9):
        raise ParameterError.must(
            "seconds", f"be above 0 and at most {min(lasting):g}, the shortest recording; got {seconds:g}"
        )
    return [max(1, round(seconds * rate)) for rate in rates]
