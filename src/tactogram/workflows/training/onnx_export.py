"""Networks of a run as ONNX files, each compared with the package's own output and described in a JSON file."""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError, RunError, one_line
from tactogram.extras import imported
from tactogram.model import ExportedNetwork, NetworkExporter, SignalKind
from tactogram.model.exported import Port
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.new_folder import new_folder
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import load_run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from torch import Tensor

OPSET = 18
"""Version of ONNX's operators: the first in which all of ours have one form."""
COMPARED = range(1, 4)
"""Seeds of the inputs that are compared; the graph is traced with those of seed 0."""
EXTRA = {"extra": "export", "what": "ONNX files"}


def export_onnx(run: Path | str, out: Path | str, *, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Write NAME.onnx and NAME.json of every network of ``run`` into the new folder ``out``; return their facts.

    Raises
    ------
    ParameterError
        If the model has no networks, or ``out`` exists.
    MissingExtraError
        If onnx, onnxscript or onnxruntime are not installed.
    RunError
        If a network cannot be exported.
    """
    imported("onnxscript", **EXTRA)
    imported("onnxruntime", **EXTRA)
    loaded = load_run(run)
    if not isinstance(loaded.model, NetworkExporter):
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} has no networks to export to ONNX")
    kind = loaded.any_kind
    facts = {"model": loaded.facts.name, "run": loaded.run.data["run_id"], "simulated": loaded.simulated}
    if isinstance(kind, SignalKind):
        per = "rate_hz" if kind.domain == "time" else "rate_per_mm"
        facts |= {per: kind.rate, "unit": kind.unit, "axes": list(kind.axes)}
    networks = loaded.model.exported_networks()
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
    import onnx
    import torch

    compared = [(given, _results(network, given)) for given in map(network.draw, COMPARED)]
    example = network.draw(0)
    _results(network, example)  # computes the constants that a trace must not
    free = {axis: torch.export.Dim(axis) for axis in network.free}
    sizes = tuple(
        {place: free[axis] for place, axis in enumerate(port.axes) if axis in free}
        for port in network.inputs.values()
    )
    with _quiet(), torch.no_grad():
        program = torch.onnx.export(
            network.network,
            example,
            dynamo=True,
            verbose=False,
            opset_version=OPSET,
            dynamic_shapes=sizes if free else None,
            input_names=list(network.inputs),
            output_names=list(network.outputs),
        )
        if program is None:  # of exporters before torch 2.6 alone
            raise RuntimeError("torch exported nothing")
        program.save(str(file))
    onnx.checker.check_model(str(file))
    _check_free(network, onnx.load(str(file), load_external_data=False).graph.input)
    return {
        "file": file.name,
        "bytes": file.stat().st_size,
        "opset": OPSET,
        "inputs": _ports(network.inputs, example, network.free),
        "outputs": _ports(network.outputs, compared[0][1], network.free),
        "difference": _differences(network, file, compared),
        **({"note": network.note} if network.note else {}),
        **network.facts,
    }


def _check_free(network: ExportedNetwork, inputs: Any) -> None:
    """Refuse a graph in which an axis that should have any size has one alone."""
    for (name, port), found in zip(network.inputs.items(), inputs, strict=True):
        for axis, size in zip(port.axes, found.type.tensor_type.shape.dim, strict=True):
            if axis in network.free and not size.dim_param:
                raise RuntimeError(f"axis {axis} of {name} must be free, the graph has {size.dim_value}")


def _results(network: ExportedNetwork, inputs: Sequence[Tensor]) -> list[Tensor]:
    """Return what the package computes."""
    import torch

    with torch.no_grad():
        found = network.network(*inputs)
    return [x for x in (found if isinstance(found, tuple) else (found,)) if x is not None]


def _named(network: ExportedNetwork, inputs: Sequence[Tensor]) -> dict[str, NDArray[Any]]:
    return {name: x.numpy() for name, x in zip(network.inputs, inputs, strict=True)}


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


def _differences(
    network: ExportedNetwork, file: Path, compared: Sequence[tuple[Sequence[Tensor], Sequence[Tensor]]]
) -> dict[str, dict[str, float]]:
    """Return how far onnxruntime is from the package, for each output.

    ``largest`` is the largest difference, in the output's unit, ``of`` the largest value, ``relative`` the root mean
    square of the differences, as a share of that of the values.
    """
    run = _session(file)
    pairs: list[list[tuple[NDArray[Any], NDArray[Any]]]] = [[] for _ in network.outputs]
    for inputs, expected in compared:
        for pair, theirs, ours in zip(pairs, run(_named(network, inputs)), expected, strict=True):
            pair.append((theirs.astype(np.float64), ours.double().numpy()))
    found = {}
    for name, pair in zip(network.outputs, pairs, strict=True):
        got, own = (np.stack([each[side] for each in pair]) for side in range(2))
        size = float(np.sqrt(np.mean(own**2)))
        found[name] = {
            "largest": float(np.abs(got - own).max()),
            "of": float(np.abs(own).max()),
            "relative": float(np.sqrt(np.mean((got - own) ** 2))) / size if size else 0.0,
        }
    return found


def _session(file: Path) -> Callable[[Mapping[str, NDArray[Any]]], list[NDArray[Any]]]:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])
    return lambda inputs: list(session.run(None, dict(inputs)))


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
