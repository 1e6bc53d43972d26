"""Classifier run as a function of a recorded window, and its threshold of "none of these" for windows."""

from __future__ import annotations

import numpy as np

from tactogram.datasets import part_examples
from tactogram.errors import ParameterError, Remedy, RunError
from tactogram.signal import Signal
from tactogram.workflows import LoadedRun, SurfaceIndex, prediction_limit, surface_vector, test_part
from tactogram_capture.live.recognition import Classification

CONTEXT_S = 0.5
"""Signal before a window in which the band-pass of a run's recipe settles. At the window's end it cannot: the samples
after it have not arrived yet."""
CALIBRATED_ON = 300
"""Largest number of validation windows that set the threshold of "none of these": a second or two at the start."""


class LiveClassifier:
    """A classifier run as a function of a recorded window; see `tactogram_capture.live.recognition.ClassifyWindow`.

    ``window_s`` is by default the length of the network's input, and ``context_s`` the signal needed before it.
    ``threshold`` is the novelty beyond which a window is none of these (None if the run has no search index),
    ``calibrated_on`` the number of windows that set it (0 if it is that of whole recordings).

    Raises `ParameterError` if the run is no classifier, or the window too short for it.
    """

    def __init__(self, loaded: LoadedRun, *, window_s: float | None = None) -> None:
        self._classifier = loaded.classifier
        if loaded.kind.domain != "time":
            raise ParameterError(
                f"{loaded.run.name}: was trained on signals over displacement, which no sensor delivers"
            )
        self.loaded, rate = loaded, loaded.kind.rate
        # Two spare samples: a slightly wrong rate must not make a window too short.
        least = loaded.config.input_samples(rate) + 2
        if window_s is None and least == 2:
            raise ParameterError(
                f"{loaded.facts.name} does not state the length of its input",
                remedy=Remedy("give its seconds as", "window"),
            )
        self.window_s = least / rate if window_s is None else window_s
        if round(self.window_s * rate) < least:
            raise ParameterError.must("window", f"be at least {least / rate:.3f} s for this run", window_s)
        self.context_s = CONTEXT_S if loaded.recipe.prepare.band is not None else 0.0
        self._index: SurfaceIndex | None = None
        self.threshold: float | None = None
        self.calibrated_on = 0
        if (loaded.run.folder / "search.json").is_file():
            self._index = SurfaceIndex.load(loaded.run)
            self._calibrate(self._index)
        self._warm_up()

    def __call__(self, signal: Signal) -> Classification:
        """Classify a window, given with its context."""
        prepared = self.loaded.prepare(signal)
        window = prepared.cut(max(0, len(prepared) - round(self.window_s * prepared.rate)))
        probabilities = self._classifier.probabilities(window)
        none_of_these = None
        if self._index is not None:
            none_of_these = self._novelty(self._index, window) > float(self.threshold or 0.0)
        names = self.loaded.kind.materials
        return Classification(dict(zip(names, probabilities.tolist(), strict=True)), none_of_these)

    def _novelty(self, index: SurfaceIndex, window: Signal) -> float:
        return index.novelty(surface_vector(self.loaded.embedder, window))

    def _calibrate(self, index: SurfaceIndex) -> None:
        """Set the threshold on windows of validation recordings.

        That of the run is of whole recordings, whose embeddings are means over many windows and lie nearer together.
        """
        self.threshold = 1.0
        loaded = self.loaded
        try:
            store, split = test_part(loaded.run)
        except RunError:
            return
        part = part_examples(store, split, "validation", loaded.as_trained, label=loaded.run.data["label"])
        length = round(self.window_s * loaded.kind.rate)
        places = [(e, start) for e in part for start in range(0, len(e.signal) - length + 1, length)]
        if not places:
            return
        chosen = np.linspace(0, len(places) - 1, min(len(places), CALIBRATED_ON)).astype(int)
        novelties = [
            self._novelty(index, places[i][0].signal.cut(places[i][1], places[i][1] + length)) for i in chosen
        ]
        self.threshold, self.calibrated_on = prediction_limit(novelties), len(novelties)

    def _warm_up(self) -> None:
        """Classify noise: the first pass through a network takes many times as long as any other."""
        kind = self.loaded.kind
        noise = np.random.default_rng(0).standard_normal((len(kind.axes), round(self.window_s * kind.rate)))
        window = Signal(noise.astype(np.float32), kind.rate, kind.unit, kind.axes)
        for _ in range(3):
            self._classifier.probabilities(window)
            if self._index is not None:
                self._novelty(self._index, window)
