"""A network without what Fabric puts around it, and one whose weights stay as they are for a while."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from torch import nn


def bare(network: Any) -> Any:
    """Return a network without Fabric around it: one process may use it while the others wait.

    Parameters
    ----------
    network : nn.Module
        As it was built, or as ``Fabric.setup`` returned it.
    """
    return getattr(network, "module", network)


@contextmanager
def fixed(network: nn.Module) -> Iterator[None]:
    """Leave the gradients of the weights of ``network`` away: the loss of another one needs none.

    Afterwards all of them learn: not for a network of which a part is frozen (`tactogram.nn.trunks`).
    """
    network.requires_grad_(False)
    try:
        yield
    finally:
        network.requires_grad_(True)
