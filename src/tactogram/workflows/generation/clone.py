"""Clone of a surface: strokes at many speeds and forces, generated from one, and a texture fitted to all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError, ParameterError, Remedy
from tactogram.parameters import Positive, checked, with_further
from tactogram.workflows.data.convert import reading_parameters
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.train import train

if TYPE_CHECKING:
    from tactogram.training.run import Run


@checked
@with_further(reading_parameters)
def clone(
    recordings: Sequence[Path | str] = (),
    *,
    out: Path | str,
    speed: Positive | None = None,
    force: Positive | None = None,
    materials: Sequence[str] = (),
    images: Sequence[Path | str] = (),
    words: Mapping[str, float] | None = None,
    speeds: tuple[float, ...] | None = None,
    forces: tuple[float, ...] | None = None,
    seconds: Positive = 4.0,
    model: str = "texture_flow",
    seed: int = 0,
    progress: ProgressCallback = silent,
    **reading: Any,
) -> Run:
    """Make a texture for any speed and force from one stroke of a surface, or from words.

    Each recording and photograph is a surface, named like its file, as are each of ``materials`` and the ``words``.
    The result is a run of `texture_var`. ``reading`` are the options of `tactogram.convert` on how a file is read.
    Its strokes are beside the run, in the store ``OUT-strokes``: those generated at each of ``speeds`` and ``forces``,
    limited to what the model predicts, which count as simulated; and a recording of 1 s or more whose speed is known,
    as of the middle one of ``forces`` if its own is not. A recording in another unit than the model's keeps its unit,
    but then all must have it. ``notes`` of the run's facts say what is outside of what the model learned,
    and ``photographs`` what each was classified as.

    Parameters
    ----------
    recordings : sequence of Path or str
        One stroke of each surface.
    out : Path or str
        Folder of the run.
    speed : float, optional
        Speed of the recordings, mm/s, if known.
    force : float, optional
        Normal force of the recordings, N, if known.
    materials : sequence of str
        Material of the model, instead of a recording.
    images : sequence of Path or str
        Photograph of a surface, instead of a recording, for a model trained on some.
    words : mapping, optional
        Scores from 1 to 7 by word, instead of a recording, e.g. rough=6,sticky=2.
    speeds : tuple of float, optional
        Speeds to generate strokes at, mm/s, by default 30, 60, 120, 240 and 400.
    forces : tuple of float, optional
        Forces to generate strokes at, N, by default 0.3, 1 and 3.
    seconds : float
        Length of each stroke, s.
    model : str
        Run that generates the strokes.
    seed : int
        Of what is drawn.

    Returns
    -------
    Run
        The finished run.

    Raises
    ------
    ParameterError
        If nothing describes a surface, two do so by one name, or the model cannot generate strokes at other speeds.
    DataError
        If a recording cannot be read, or ``OUT-strokes`` holds other strokes.
    RunError
        If ``out`` holds a run.
    """
    from tactogram.datasets import create_store, open_store
    from tactogram.model import limits_within
    from tactogram.signal.io.atomic import check_writable
    from tactogram.signal.texture_map import NAMES
    from tactogram.training.run import Run
    from tactogram.workflows.generation.cloned_strokes import (
        FORCES_N,
        SPEEDS_MM_S,
        described_surfaces,
        strokes_of,
    )
    from tactogram.workflows.generation.generate import run_provenance
    from tactogram.workflows.generation.photographs import description_facts
    from tactogram.workflows.training.loaded_run import load_run

    out, speeds, forces = Path(out), speeds or SPEEDS_MM_S, forces or FORCES_N
    strokes = out.with_name(f"{out.name}-strokes")
    check_writable(out, folder=True)
    Run(out).check_free()
    loaded = load_run(model)
    ranges = loaded.model.predicted_ranges
    if not ranges:
        raise ParameterError(
            f"{model} predicts no other speeds and forces; take texture_flow as it comes trained, or train it "
            "on recordings at several speeds with config.prediction=true"
        )
    surfaces, limited = described_surfaces(
        loaded,
        recordings=recordings,
        reading=reading,
        speed=speed,
        force=force,
        images=images,
        materials=materials,
        words=words,
    )
    for name, values, default in zip(NAMES, (speeds, forces), (SPEEDS_MM_S, FORCES_N), strict=True):
        known = {name: ranges[name]} if name in ranges else {}
        limited += [
            str(limit) for value in {*values} - {*default} for limit in limits_within({name: value}, known)
        ]
    generated = list(
        strokes_of(
            loaded,
            surfaces,
            ranges,
            recorded_at=(speed, force),
            speeds=speeds,
            forces=forces,
            seconds=seconds,
            seed=seed,
            progress=progress,
        )
    )
    if strokes.exists():  # of a clone that was interrupted
        store = open_store(strokes)
        if not all(map(store.holds, generated)) or len(store) > len(generated):
            raise DataError(strokes, "holds other strokes", remedy=Remedy("choose another", "out"))
    else:
        store = create_store(
            strokes,
            generated,
            name=f"clones of {', '.join(surfaces)}",
            licence="that of the recordings",
            source=f"tactogram clone, by {run_provenance(loaded, seed)['run']}",
            simulated=True,
        )
    run = train("texture_var", store.path, out=out, split="all", progress=progress)
    facts = run.facts()
    photographs = {
        name: description_facts(loaded, surface) for name, surface in surfaces.items() if "image" in surface
    }
    seen = {"photographs": photographs} if photographs else {}
    run.write_json("model.json", facts | {"notes": [*facts["notes"], *limited]} | seen)
    return run
