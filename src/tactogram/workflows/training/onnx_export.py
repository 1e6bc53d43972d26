"""Networks of a run as ONNX files, each compared with the package's own output and described in a JSON file."""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.datasets.store.pending import new_folder
from tactogram.errors import ParameterError, RunError, one_line
from tactogram.extras import imported
from tactogram.model import ExportedNetwork, SignalKind
from tactogram.model.exported import Port
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import load_run

if TYPE_CHECKING:
    from torch import Tensor

OPSET = 18
"""Version of ONNX's operators: the first in which all of ours have one form."""
COMPARED = range(1, 4)
"""Seeds of the inputs that are compared; the graph is traced with those of seed 0."""
MOST_DIFFERENCE = 1e-4
"""Largest difference between onnxruntime and the package, as a share of the largest value."""
EXTRA = {"extra": "export", "what": "ONNX files"}


def export_onnx(run: Path | str, out: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Write NAME.onnx and NAME.json of every network of ``run`` into the new folder ``out``; return their facts.

    Raises
    ------
    ParameterError
        If the model has no networks, or ``out`` exists.
    MissingExtraError
        If onnxscript or onnxruntime are not installed.
    RunError
        If a network cannot be exported, or computes something else in onnxruntime.
    """
    imported("onnxscript", **EXTRA)
    imported("onnxruntime", **EXTRA)
    loaded = load_run(run)
    networks = loaded.model.exported_networks()
    if not networks:
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} has no networks to export to ONNX")
    kind = loaded.any_kind
    facts = {"model": loaded.facts.name, "run": loaded.run.data["run_id"], "simulated": loaded.simulated}
    if isinstance(kind, SignalKind):
        per = "rate_hz" if kind.domain == "time" else "rate_per_mm"
        facts |= {per: kind.rate, "unit": kind.unit, "axes": list(kind.axes)}
    found = {}
    with new_folder(Path(out)) as folder:
        for number, (name, network) in enumerate(networks.items()):
            progress("export", number, len(networks), name)
            try:
                described = export_network(network, folder / f"{name}.onnx")
            except RuntimeError as error:  # of torch's exporter and of onnxruntime alike
                raise RunError(f"{loaded.run.name}: {name} cannot be exported: {one_line(error)}") from error
            found[name] = facts | described
            write_text(folder / f"{name}.json", json.dumps(found[name], indent=1, ensure_ascii=False) + "\n")
    progress("export", len(networks), len(networks))
    return {"folder": str(out), "networks": found}


def export_network(network: ExportedNetwork, file: Path) -> dict[str, Any]:
    """Write one network as an ONNX file, and return what its JSON file says of it."""
    import torch

    example = network.draw(0)
    outputs = _results(network, example)  # computes the constants that a trace must not
    free = {axis: torch.export.Dim(axis) for axis in network.free}
    sizes = tuple(
        {place: free[axis] for place, axis in enumerate(port.axes) if axis in free}
        for port in network.inputs.values()
    )
    with _quiet(), torch.no_grad():
        program: Any = torch.onnx.export(
            network.network,
            example,
            dynamo=True,
            verbose=False,
            opset_version=OPSET,
            dynamic_shapes=sizes if free else None,
            input_names=list(network.inputs),
            output_names=list(network.outputs),
        )
        differences = _differences(network, program)
        program.save(str(file))
    return {
        "file": file.name,
        "bytes": file.stat().st_size,
        "opset": OPSET,
        "inputs": _ports(network.inputs, example, network.free),
        "outputs": _ports(network.outputs, outputs, network.free),
        "difference": differences,
        **({"note": network.note} if network.note else {}),
        **network.facts,
    }


def _results(network: ExportedNetwork, inputs: Sequence[Tensor]) -> list[Tensor]:
    """Return what the package computes."""
    import torch

    with torch.no_grad():
        found = network.network(*inputs)
    return list(found) if isinstance(found, tuple) else [found]


def _differences(network: ExportedNetwork, program: Any) -> dict[str, float]:
    """Return how far each output in onnxruntime is from the package's at most, as a share of its largest value.

    Raises a RuntimeError if that is too far.
    """
    found = dict.fromkeys(network.outputs, 0.0)
    for inputs in map(network.draw, COMPARED):
        for name, theirs, ours in zip(found, program(*inputs), _results(network, inputs), strict=True):
            found[name] = max(found[name], float((theirs - ours).abs().max() / ours.abs().max()))
    for name, difference in found.items():
        if not difference <= MOST_DIFFERENCE:
            raise RuntimeError(f"{name} differs in onnxruntime by {difference:.2g} of its largest value")
    return found


def _ports(ports: Mapping[str, Port], tensors: Sequence[Tensor], free: Sequence[str]) -> list[dict[str, Any]]:
    """Return inputs or outputs as JSON values; a free axis has the size null."""
    return [
        {
            "name": name,
            "axes": list(port.axes),
            "shape": [None if axis in free else n for axis, n in zip(port.axes, x.shape, strict=True)],
            "type": str(x.dtype).removeprefix("torch."),
            "unit": port.unit,
            "meaning": port.meaning,
        }
        for (name, port), x in zip(ports.items(), tensors, strict=True)
    ]


@contextmanager
def _quiet() -> Iterator[None]:
    """Without the notes of torch's exporter."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)
