"""Search for surfaces: the nearest recordings to a new one, or "none of these".

Saga et al. propose their classifier "as a search engine for surface material retrieval". The index is that of the run
(`workflows.training.surface_index`), or of another store.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Examples, Segment, Store, label_of, open_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal, signal_of
from tactogram.workflows.recognition.spectral_search import cache_vectors, cached
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram.workflows.training.surface_index import (
    SurfaceIndex,
    surface_vector,
    surface_vectors,
)


def search(
    run: Path | str | LoadedRun, signal: Signal, *, data: Path | str | None = None, count: int = 5
) -> dict[str, Any]:
    """Find the recordings nearest to a signal.

    Parameters
    ----------
    run : Path, str or LoadedRun
        Run of a classifier.
    signal : Signal
        A recording; it is prepared by the run's recipe.
    data : Path or str, optional
        Data set to search, by default the training data.
    count : int
        Number of results.

    Returns
    -------
    dict
        ``nearest`` (``id``, ``material``, ``distance``), ``materials`` (each once, by its nearest
        recording), ``none_of_these`` (bool), ``distance`` of the nearest and ``threshold`` (1: that of two
        recordings of one material, as a root mean square over the training data).

    Raises
    ------
    ParameterError
        If ``count`` is below 1, or the run is no classifier.

    Examples
    --------
    >>> import tactogram
    >>> found = tactogram.search("runs/cnn", tactogram.read_signal("stroke.wav"), count=3)  # doctest: +SKIP
    >>> nearest = found["nearest"][0]["material"]  # doctest: +SKIP
    """
    if count < 1:
        raise ParameterError.must("count", "be at least 1", count)
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    index = SurfaceIndex.load(loaded.run)
    simulated = loaded.simulated
    if data is not None:
        store = open_store(data)
        simulated = simulated or store.simulated
        index = _index_of(loaded, store, index)
    vector = surface_vector(loaded.embedder, loaded.prepare(signal_of(signal)))
    every = index.nearest(vector, len(index.ids))
    materials: dict[str, float] = {}
    for neighbour in every:
        materials.setdefault(neighbour["material"], neighbour["distance"])
    return {
        "nearest": every[:count],
        "materials": [{"material": m, "distance": d} for m, d in list(materials.items())[:count]],
        "none_of_these": every[0]["distance"] > index.threshold,
        "distance": every[0]["distance"],
        "threshold": index.threshold,
        "calibrated_on": index.calibrated_on,
        "simulated": simulated,
    }


def _index_of(loaded: LoadedRun, store: Store, trained: SurfaceIndex) -> SurfaceIndex:
    """Return an index over ``store`` with the distances of the run's own.

    The run keeps embeddings by recording, so only new recordings are embedded.
    """
    file = loaded.run.folder / "search-embedded.npz"
    label = loaded.run.data["label"]
    names = {info.id: name for info in store.index if (name := label_of(info, label)) is not None}
    if not names:
        raise ParameterError(f"{store.name}: no recording has a {label}: there is nothing to search")
    held = cached(file)
    missing = [id for id in names if id not in held]
    if missing:
        examples = Examples(store, map(Segment, missing), loaded.as_trained, label=label)
        held |= dict(zip(missing, surface_vectors(loaded.embedder, examples), strict=True))
        cache_vectors(file, held)
    return SurfaceIndex(
        np.stack([held[id] for id in names]),
        list(names),
        list(names.values()),
        whitening=trained.whitening,
        threshold=trained.threshold,
        calibrated_on=trained.calibrated_on,
    )
