"""Access to a network without Fabric's wrapper, or without gradients."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import Any

from torch import nn


def bare(network: Any) -> Any:
    """Return a network without Fabric's wrapper, if any: one process may use it while the others wait."""
    return getattr(network, "module", network)


def for_export(network: Any) -> Any:
    """Return a copy of a network in evaluation mode, on the CPU and without Fabric's wrapper."""
    return deepcopy(bare(network)).cpu().eval().requires_grad_(False)


@contextmanager
def fixed(network: nn.Module) -> Iterator[None]:
    """Skip the gradients of the weights of ``network`` while another one is updated.

    Afterwards all weights need gradients: not for networks with a frozen part (`tactogram.nn.trunks`).
    """
    network.requires_grad_(False)
    try:
        yield
    finally:
        network.requires_grad_(True)
