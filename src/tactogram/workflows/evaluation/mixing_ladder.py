"""Ladder of mixes of two materials from a trained generator: sounds, figure and measures."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge

from tactogram.errors import ParameterError, RunError
from tactogram.parameters import checked
from tactogram.workflows.progress import ProgressCallback, silent

if TYPE_CHECKING:
    from tactogram.evaluation.mixing.ladder import MixSeries
    from tactogram.evaluation.mixing.placement import MixingLadder
    from tactogram.signal import Signal
    from tactogram.workflows.training.loaded_run import LoadedRun

Mode = Literal["sum", "add"]
Several = Annotated[int, Ge(2)]


def mix_ladder(
    run: Path | str | LoadedRun,
    start: str,
    end: str,
    *,
    mode: Mode = "sum",
    steps: int = 11,
    signals: int = 6,
    speed_mm_s: float | None = None,
    force_n: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    progress: ProgressCallback = silent,
) -> MixSeries:
    """Generate a ladder of mixes and measure it, without writing anything.

    Every signal measured has its own seed. Parameters are those of `mixing_ladder`.

    Raises `ParameterError` if the materials are the same, unknown or cannot be distinguished.
    """
    import numpy as np

    from tactogram.evaluation.mixing.ladder import MixSeries
    from tactogram.evaluation.mixing.placement import positions
    from tactogram.signal import Signal
    from tactogram.training.seeds import child_seed
    from tactogram.workflows.generation.generate import generate
    from tactogram.workflows.training.loaded_run import LoadedRun, load_run

    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if "words" in (known := loaded.facts.conditions) and "material" not in known:
        raise ParameterError(
            f"{loaded.run.name}: mixes are of materials; {loaded.facts.name} is conditioned on words"
        )
    if start == end:
        raise ParameterError(f"a ladder needs two materials, got {start!r} twice")
    weights = np.round(np.linspace(0, 1, steps), 12)  # 0.3, not 0.30000000000000004
    mixes = [{start: 1.0 if mode == "add" else round(float(1 - w), 12), end: float(w)} for w in weights]
    done, total = 0, (steps + 2) * signals + steps

    def draw(material: dict[str, float], purpose: str, number: int, count: int) -> list[Signal]:
        nonlocal done
        # The steps differ in chance as well: with one seed the ladder would look smoother than it is.
        own = seed if purpose == "shown" else child_seed(seed, "mixing", purpose, number)
        condition = _stroke(speed_mm_s, force_n) | {"material": material}
        drawn = []
        for signal in generate(loaded, condition, seconds=seconds, seed=own, count=count):
            if not isinstance(signal, Signal):
                raise ParameterError(
                    f"{loaded.run.name}: {loaded.facts.name} gives images, which are not mixed"
                )
            drawn.append(signal)
            done += 1
            progress("mix", done, total)
        return drawn

    ends = [draw({name: 1.0}, "end", number, signals) for number, name in enumerate((start, end))]
    mixed = [draw(mix, "step", number, signals) for number, mix in enumerate(mixes)]
    ladder = positions(mixed, *ends, weights=weights, seed=seed)
    try:
        real = [recorded(loaded, name) for name in (start, end)]
    except RunError:  # the recordings are not here: the run was imported, or its data moved
        real = [[], []]
    return MixSeries(
        start=start,
        end=end,
        mode=mode,
        shown=tuple(draw(mix, "shown", 0, 1)[0] for mix in mixes),
        ladder=ladder,
        without_level=_if_apart(mixed, *ends, weights=weights, seed=seed, level=False),
        against_recordings=_if_apart(mixed, *real, weights=weights, seed=seed),
        simulated=loaded.simulated,
    )


@checked
def mixing_ladder(
    run: Path | str | LoadedRun,
    start: str,
    end: str,
    *,
    mode: Mode = "sum",
    steps: Several = 11,
    signals: Several = 6,
    speed_mm_s: float | None = None,
    force_n: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    out: Path | str | None = None,
    reuse: bool = False,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Generate a ladder of mixes of two materials, and measure where each step lies.

    ``ladder.png``, the steps as WAV and ``ladder.json`` are written to ``out``; with ``reuse`` a ladder of the same
    parameters that is there is returned.

    Parameters
    ----------
    run : Path, str or LoadedRun
        Run of a generator.
    start, end : str
        Materials at the ends.
    mode : str
        Weights that sum to 1, or the first at 1 and the second added.
    steps : int
        Weights of the second from 0 to 1.
    signals : int
        Signals measured at each step.
    speed_mm_s : float, optional
        Stroking speed, mm/s.
    force_n : float, optional
        Normal force, N.
    seconds : float, optional
        Length of each, by default the model's own.
    seed : int
        Of what is drawn.
    out : Path or str, optional
        Folder for figure, sounds and JSON, by default RUN/mixing/A-B-MODE.

    Returns
    -------
    dict
        The parameters (``model``, ``run``, ``start``, …), ``simulated``, ``in_words``, ``figure``, ``sounds``, and
        `MixingLadder.as_dict` as ``ladder``, ``without_level`` and ``against_recordings`` (None where there is none).

    Raises
    ------
    ParameterError
        If the materials are the same, unknown or cannot be distinguished, or ``out`` cannot be written to.
    """
    from tactogram.evaluation.mixing.ladder import MODES
    from tactogram.evaluation.report import save_figure
    from tactogram.signal.io import write_signal
    from tactogram.signal.io.atomic import check_writable, write_text
    from tactogram.workflows.training.loaded_run import LoadedRun, load_run

    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    settings: dict[str, Any] = {
        "mode": mode,
        "steps": steps,
        "signals": signals,
        "seconds": seconds,
        "seed": seed,
    }
    requested = {
        "model": loaded.facts.name,
        "run": loaded.run.data["run_id"],
        "start": start,
        "end": end,
        **settings,
        "condition": _stroke(speed_mm_s, force_n),
    }
    own = loaded.run.folder / "mixing" / _file(f"{start}-{end}-{mode}")
    folder = Path(out) if out else own
    if reuse and (known := _read(folder / "ladder.json")) and requested.items() <= known.items():
        return known
    check_writable(folder, folder=True)
    mixes = mix_ladder(
        loaded, start, end, **settings, speed_mm_s=speed_mm_s, force_n=force_n, progress=progress
    )
    folder.mkdir(parents=True, exist_ok=True)
    sounds = []
    for step, signal in enumerate(mixes.shown):
        file = folder / _file(f"{step:02}-{end}-{mixes.ladder.weights[step]:.2g}.wav")
        write_signal(
            file,
            signal,
            metadata={
                "generated_by": f"tactogram {loaded.facts.name}",
                "material": {end: mixes.ladder.weights[step], start: mixes.start_weights[step]},
                "seed": seed,
                "simulated": mixes.simulated,
            },
        )
        sounds.append(str(file))
    title = f"{loaded.facts.name}: {start} to {end}, {MODES[mode]}"
    figure = mixes.figure(title=title + (" (trained on simulated data)" if mixes.simulated else ""))
    result = {
        **requested,
        "simulated": mixes.simulated,
        "in_words": mixes.in_words(),
        "ladder": mixes.ladder.as_dict(),
        "without_level": mixes.without_level and mixes.without_level.as_dict(),
        "against_recordings": mixes.against_recordings and mixes.against_recordings.as_dict(),
        "figure": str(save_figure(folder / "ladder.png", figure)),
        "sounds": sounds,
    }
    write_text(folder / "ladder.json", json.dumps(result, indent=1, ensure_ascii=False) + "\n")
    return result


def _stroke(speed_mm_s: float | None, force_n: float | None) -> dict[str, Any]:
    """Return speed and force, where given."""
    known = {"speed_mm_s": speed_mm_s, "force_n": force_n}
    return {name: value for name, value in known.items() if value is not None}


def recorded(run: Path | str | LoadedRun, material: str) -> list[Signal]:
    """Return the recordings of ``material`` that the run was not trained on, prepared; empty if it kept none."""
    from tactogram.datasets import Examples, label_of
    from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part

    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    store, split = test_part(loaded.run)
    label = loaded.run.data["label"]
    kept = [s for s in split.test if label_of(store.info(s.id), label) == material]
    return [example.signal for example in Examples(store, kept, loaded.as_trained, label=label)]


def _if_apart(
    steps: Sequence[Sequence[Signal]], start: Sequence[Signal], end: Sequence[Signal], **options: Any
) -> MixingLadder | None:
    """Return the ladder between two ends, None where there are too few signals or they are alike."""
    from tactogram.evaluation.mixing.placement import IndistinctEndsError, positions

    if min(len(start), len(end)) < 2:
        return None
    try:
        return positions(steps, start, end, **options)
    except IndistinctEndsError:
        return None


def _read(file: Path) -> dict[str, Any] | None:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def _file(name: str) -> str:
    """Return ``name`` as a file name of every system."""
    return re.sub(r"[^\w.=-]+", "_", name)
