"""Networks of a trained model, described for other runtimes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from torch import Tensor, nn


@dataclass(frozen=True)
class Port:
    """Input or output of a network.

    Parameters
    ----------
    axes : tuple of str
        Names of its axes. An axis of the same name has the same size at every port.
    meaning : str
        One line, e.g. ``"photograph, -1 to 1"``.
    unit : str
    """

    axes: tuple[str, ...]
    meaning: str
    unit: str = "1"


@dataclass(frozen=True, eq=False)
class ExportedNetwork:
    """A network as the model uses it, from physical inputs to physical outputs where that is part of the graph.

    Parameters
    ----------
    network : torch.nn.Module
        In evaluation mode, on the CPU. Draws no random numbers: these are inputs.
    draw : callable
        Returns typical inputs for a seed, one tensor per input; batches have two elements or more.
    inputs, outputs : mapping from str to Port
        In the order of the arguments and results of ``network``.
    free : tuple of str
        Axes of any size; every other axis has the size it is drawn with.
    note : str
        What the network leaves to its caller.
    facts : mapping
        JSON values that a caller needs, e.g. the names behind a label.
    """

    network: nn.Module
    draw: Callable[[int], tuple[Tensor, ...]]
    inputs: Mapping[str, Port]
    outputs: Mapping[str, Port]
    free: tuple[str, ...] = ("batch",)
    note: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)
