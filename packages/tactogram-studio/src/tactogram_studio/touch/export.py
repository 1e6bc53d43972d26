"""The verb `touch`: a texture as a JSON document, for a page of one's own or an engine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from annotated_types import Interval

from tactogram.models import shipped_run
from tactogram.parameters import checked
from tactogram.signal.io import write_text
from tactogram_studio.touch.document import texture_document
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.sources import TextureRequest, TouchSources
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive


@checked
def touch(
    source: Path | str,
    *,
    out: Path | str,
    material: str = "",
    speed: Annotated[float, Interval(ge=1, le=2000)] | None = None,
) -> dict[str, Any]:
    """Write a texture as JSON, for <tactogram-pad> in a page of your own and for engines.

    The texture is what the page Touch of the studio plays of the same source (`tactogram_studio.touch.document`).

    Parameters
    ----------
    source : Path or str
        Folder of a run, e.g. of `clone`, or a file of a signal.
    out : Path or str
        JSON file.
    material : str, optional
        Material of the run.
    speed : float, optional
        Speed of the recording, where its file does not state it (default: 100), or at which a run generates, mm/s.

    Returns
    -------
    dict
        ``file``, ``name``, ``kind``, ``follows``, ``unit``, ``simulated``, ``notes`` and ``bytes``.

    Raises
    ------
    TactogramError
        If the source cannot be read, has no such material, or is silent.
    """
    path = Path(source).resolve()
    run = bool(shipped_run(str(source))) or path.is_dir()
    # As in the studio a run's photographs are found from the folder in which it was trained.
    folder = Path.cwd() if path.is_relative_to(Path.cwd()) else path.parents[min(1, len(path.parents) - 1)]
    workspace = Workspace(folder)
    sources = TouchSources(workspace, ResultArchive(workspace.studio_folder / "kept"))
    of = str(source) if shipped_run(str(source)) else path.relative_to(folder).as_posix()
    request = TextureRequest(where="run" if run else "file", of=of, material=material, speed_mm_s=speed)
    table = sources.table(request)
    text = texture_document(table, picture_of(sources, request))
    write_text(Path(out), text)
    facts = {name: table.head[name] for name in ("name", "kind", "follows", "unit", "simulated", "notes")}
    return {"file": str(out), **facts, "bytes": len(text.encode())}
