"""Runs in forms that other programs read."""

from __future__ import annotations

from typing import Any

from tactogram.errors import ParameterError
from tactogram.workflows.request import takes
from tactogram.workflows.training.requests import ExportRequest
from tactogram.workflows.training.run_archive import export_run

OPTIONS = {
    "push": (None, "hub"),
    "material": (None, "c"),
    "speed": (None, "c"),
    "force": (None, "c"),
    "axis": ("dft321", "c"),
}
"""Options of one form alone: their defaults, and that form."""


@takes(ExportRequest)
def export(request: ExportRequest) -> dict[str, Any]:
    """Write a run in the form that ``to`` names, and return what was written.

    Raises
    ------
    ParameterError
        If the model has no such form, or an option is of another form.
    """
    for name, (default, form) in OPTIONS.items():
        if getattr(request, name) != default and request.to != form:
            raise ParameterError(f"{name} must be omitted with to={request.to!r}: it is for {form}")
    if request.to == "onnx":
        from tactogram.workflows.training.onnx_export import export_onnx

        return export_onnx(request.run, request.out, progress=request.progress)
    if request.to == "c":
        from tactogram.workflows.training.c_export import export_c

        return export_c(
            request.run,
            request.out,
            material=request.material,
            speed=request.speed,
            force=request.force,
            axis=request.axis,
        )
    if request.to == "hub":
        from tactogram.workflows.training.hub_folder import export_hub

        return export_hub(request.run, request.out, push=request.push)
    return export_run(request.run, request.out)
