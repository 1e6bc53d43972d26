"""Runs in forms that other programs read, and back from a zip file or the Hub."""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge

from tactogram.errors import ParameterError, Remedy, RunError, one_line
from tactogram.extras import imported
from tactogram.parameters import checked
from tactogram.workflows.progress import ProgressCallback, silent

if TYPE_CHECKING:
    from torch import Tensor

    from tactogram.model import ExportedNetwork
    from tactogram.model.model import Port

OPTIONS = {
    "push": (None, "hub"),
    "material": (None, "c"),
    "speed": (None, "c"),
    "force": (None, "c"),
    "axis": ("dft321", "c"),
}
"""Options of one form alone: their defaults, and that form."""
OPSET = 18
"""Version of ONNX's operators: the first in which all of ours have one form."""
COMPARED = range(1, 4)
"""Seeds of the inputs that are compared; the graph is traced with those of seed 0."""
MOST_DIFFERENCE = 1e-4
"""Largest difference between onnxruntime and the package, as a share of the largest value."""
EXTRA = {"extra": "export", "what": "ONNX files"}


@checked
def export(
    run: Path | str,
    *,
    out: Path | str,
    to: Literal["zip", "onnx", "c", "hub"] = "zip",
    material: str | None = None,
    speed: Annotated[float, Ge(0)] | None = None,
    force: Annotated[float, Ge(0)] | None = None,
    push: str | None = None,
    axis: str = "dft321",
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Write a finished run in another form, which does not need this package, and return what was written.

    Parameters
    ----------
    run : Path or str
        Folder of the run.
    out : Path or str
        Zip file, header file, or new folder.
    to : str
        zip: one file to import again; onnx: the network for onnxruntime; c: a texture for a microcontroller; hub: a
        folder in the layout of the Hugging Face Hub.
    material : str, optional
        c: the material.
    speed, force : float, optional
        c: mm/s and N, by default the median recorded.
    push : str, optional
        hub: also upload it, e.g. as lab/cork.
    axis : str
        c: an axis by name, dft321 (all in one) or all.

    Returns
    -------
    dict
        Of a zip ``file``, ``files`` and ``bytes``; of networks ``folder`` and, by name, ``networks``; of a texture
        ``file``, ``name``, ``material``, ``rate_hz`` and its cost; of the Hub's layout ``folder``, ``files``, ``bytes``
        and ``pushed``.

    Raises
    ------
    ParameterError
        If the model has no such form, or an option is of another form.
    RunError
        If the run is not finished.
    """
    from tactogram.workflows.training.hub_folder import export_hub, export_run

    options = {"push": push, "material": material, "speed": speed, "force": force, "axis": axis}
    for name, (default, form) in OPTIONS.items():
        if options[name] != default and to != form:
            raise ParameterError(f"{name} must be omitted with to={to!r}: it is for {form}")
    if to != "c" and Path(out).suffix == ".h":
        raise ParameterError(out, f"the suffix of a header, but to={to!r}", remedy=Remedy("give", "to", "c"))
    if to == "onnx":
        return export_onnx(run, out, progress=progress)
    if to == "c":
        return export_c(run, out, material=material, speed=speed, force=force, axis=axis)
    return export_hub(run, out, push=push) if to == "hub" else export_run(run, out)


@checked
def import_from(source: str | Path, *, out: Path | str) -> dict[str, Any]:
    """Put a run from a zip file, a folder in the layout of the Hugging Face Hub, or the Hub itself into a folder.

    Parameters
    ----------
    source : str or Path
        Zip file, folder, or hf://OWNER/NAME of the Hub.
    out : Path or str
        Folder of the run.

    Returns
    -------
    dict
        ``run`` and ``files``.

    Raises
    ------
    RunError
        If it is no run, cannot be had, or ``out`` exists.
    """
    from tactogram.workflows.training.hub_folder import import_hub, import_run

    if str(source).startswith("hf://") or Path(source).is_dir():
        return import_hub(source, out)
    return import_run(source, out)


def export_c(
    run: Path | str,
    out: Path | str,
    *,
    material: str | None = None,
    speed: float | None = None,
    force: float | None = None,
    axis: str = "dft321",
) -> dict[str, Any]:
    """Write a material at a speed (mm/s) and force (N), by default the median recorded ones; return the header's facts.

    Raises
    ------
    ParameterError
        If the run has no modulated noise, no such material, or unknown speeds or forces.
    """
    from tactogram.rendering.embedded.noise_header import c_name, noise_header, one_axis
    from tactogram.signal.io.atomic import write_text
    from tactogram.signal.texture_map import NoiseMap
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(run)
    maps = {
        name: each
        for name, each in zip(loaded.kind.materials, loaded.model.maps, strict=False)
        if isinstance(each, NoiseMap)
    }
    if not maps:
        raise ParameterError(
            f"{loaded.run.name}: a C header needs a run of texture_var, this is {loaded.facts.name}"
        )
    if material not in maps:
        raise ParameterError.one_of("material", maps, material)
    texture = one_axis(maps[material].at(speed, force), axis)
    stroke = [f"{value:g} {unit}" for value, unit in ((speed, "mm/s"), (force, "N")) if value is not None]
    facts = [
        f"Material {material} of run {loaded.run.data['run_id']}, {' and '.join(stroke) or 'median speed and force'}.",
        *(["Learned from simulated recordings."] if loaded.simulated else []),
    ]
    name = c_name(material)
    text, cost = noise_header(texture, name=name, facts=facts)
    write_text(Path(out), text)
    return {"file": str(out), "name": name, "material": material, "rate_hz": texture.rate, **asdict(cost)}


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
    from tactogram.datasets.store.pending import new_folder
    from tactogram.model import SignalKind
    from tactogram.signal.io.atomic import write_text
    from tactogram.workflows.training.loaded_run import load_run

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
    saved = {}
    with new_folder(Path(out)) as folder:
        for number, (name, network) in enumerate(networks.items()):
            progress("export", number, len(networks), name)
            try:
                described = export_network(network, folder / f"{name}.onnx")
            except RuntimeError as error:  # of torch's exporter and of onnxruntime alike
                raise RunError(f"{loaded.run.name}: {name} cannot be exported: {one_line(error)}") from error
            saved[name] = facts | described
            write_text(folder / f"{name}.json", json.dumps(saved[name], indent=1, ensure_ascii=False) + "\n")
    progress("export", len(networks), len(networks))
    return {"folder": str(out), "networks": saved}


def export_network(network: ExportedNetwork, file: Path) -> dict[str, Any]:
    """Write one network as an ONNX file, and return what its JSON file says of it."""
    import torch

    example = network.draw(0)
    outputs = _results(network, example)  # computes the constants that a trace must not
    free = {axis: torch.export.Dim(axis) for axis in network.free}
    sizes = tuple(
        {dimension: free[axis] for dimension, axis in enumerate(port.axes) if axis in free}
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
        outputs = network.network(*inputs)
    return list(outputs) if isinstance(outputs, tuple) else [outputs]


def _differences(network: ExportedNetwork, program: Any) -> dict[str, float]:
    """Return how far each output in onnxruntime is from the package's at most, as a share of its largest value.

    Raises a RuntimeError if that is too far.
    """
    differences = dict.fromkeys(network.outputs, 0.0)
    for inputs in map(network.draw, COMPARED):
        for name, theirs, ours in zip(differences, program(*inputs), _results(network, inputs), strict=True):
            differences[name] = max(differences[name], float((theirs - ours).abs().max() / ours.abs().max()))
    for name, difference in differences.items():
        if not difference <= MOST_DIFFERENCE:
            raise RuntimeError(f"{name} differs in onnxruntime by {difference:.2g} of its largest value")
    return differences


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
