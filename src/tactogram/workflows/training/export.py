"""Runs in forms that other programs read."""

from __future__ import annotations

from typing import Any

from tactogram.errors import ParameterError
from tactogram.workflows.request import takes
from tactogram.workflows.training.requests import ExportRequest
from tactogram.workflows.training.run_archive import export_run


@takes(ExportRequest)
def export(request: ExportRequest) -> dict[str, Any]:
    """Write a run in the form that ``to`` names, and return what was written.

    Raises
    ------
    ParameterError
        If the model has no such form, or an option is of another form.
    """
    if request.to == "onnx":
        from tactogram.workflows.training.onnx_export import export_onnx

        return export_onnx(request.run, request.out, int8=request.int8, progress=request.progress)
    if request.int8:
        raise ParameterError(f"int8 must be omitted with to={request.to!r}: it is for onnx")
    return export_run(request.run, request.out)
