"""Stores in layouts that other programs read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.datasets import open_store
from tactogram.errors import ParameterError
from tactogram.workflows import hub
from tactogram.workflows.data.hub_layout import write_hub_dataset
from tactogram.workflows.data.lerobot_layout import write_lerobot_dataset
from tactogram.workflows.data.requests import DataExportRequest
from tactogram.workflows.new_folder import new_folder
from tactogram.workflows.request import takes

FPS = 50


@takes(DataExportRequest)
def export_store(request: DataExportRequest) -> dict[str, Any]:
    """Write a store into the new folder ``out``, and upload it as ``push`` if given; return what was written.

    Raises `ParameterError` if the layout cannot hold the store; `RunError` if ``out`` exists, or the upload fails;
    `MissingExtraError` if huggingface_hub is not installed.
    """
    hub.hub_library()
    store = open_store(request.path)
    if not len(store):
        raise ParameterError(f"{request.path} has no recordings")
    if request.fps is not None and request.to != "lerobot":
        raise ParameterError(f"fps must be omitted with to={request.to!r}: it is for lerobot")
    with new_folder(Path(request.out)) as folder:
        if request.to == "lerobot":
            fps = request.fps or FPS
            facts = write_lerobot_dataset(store, folder, fps=fps, progress=request.progress)
        else:
            facts = write_hub_dataset(store, folder)
    facts = {"path": str(request.out), **facts}
    if request.push:
        facts["pushed"] = hub.push(Path(request.out), request.push, kind="dataset")
    return facts
