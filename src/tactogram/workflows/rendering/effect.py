"""Ready effects as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.parameters import Positive, Share, checked


@checked
def write_effect(
    name: str | None = None,
    *,
    out: Path | str | None = None,
    format: str | None = None,
    seconds: Positive | None = None,
    strength: Share = 1.0,
    seed: int = 0,
) -> dict[str, Any]:
    """List the ready effects, or write one as a haptic file or a signal.

    Parameters
    ----------
    name : str, optional
        Effect to write, e.g. heartbeat or 'button press' (default: list all).
    out : Path or str, optional
        A haptic file (.ahap, .haptic, …) or a signal (.wav, .csv, …).
    format : str, optional
        Format of the file, one of `convert --list`: if several share its suffix (.json).
    seconds, strength, seed
        As of `tactogram.effect`.

    Returns
    -------
    dict
        ``effect``, ``about``, ``file``, ``seconds``, and of a haptic file ``written`` (as of `write_haptic`); of the
        list, by name, ``about``, ``also`` (other names) and ``seconds``.

    Raises
    ------
    ParameterError
        As `effect`, `write_haptic` and `write_signal`; nothing is written then.
    """
    from tactogram.rendering.files.analysis import carrier
    from tactogram.rendering.files.conversion import write_haptic
    from tactogram.rendering.ready_effects import effect, effects, find_effect
    from tactogram.signal.io import write_signal
    from tactogram.workflows.data.sources import target_format

    if name is None:
        return {
            each.name: {"about": each.about, "also": list(each.also), "seconds": each.seconds}
            for each in effects().values()
        }
    ready = find_effect(name)
    if out is None:
        remedy = f"name a haptic file or a signal, e.g. {ready.name}.ahap"
        raise ParameterError("must be given", parameter="out", remedy=remedy)
    kind = target_format(Path(out), format)
    events = effect(ready.name, seconds=seconds, strength=strength, seed=seed)
    metadata = {"effect": ready.name, "strength": strength, "seed": seed}
    facts = {"effect": ready.name, "about": ready.about, "file": str(out), "seconds": events.seconds}
    if kind is None:
        write_signal(out, carrier(events), metadata=metadata)
        return facts
    return facts | {"written": write_haptic(out, events, format=kind.name, metadata=metadata)}
