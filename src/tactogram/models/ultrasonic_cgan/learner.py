"""Training of one CGAN per cluster of surfaces; a loop for the display from scores and a sensor spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from matplotlib.figure import Figure
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, Example, Model, SignalKind, Stage, check_state
from tactogram.models.ultrasonic_cgan.cluster_evaluation import figures_of
from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.drive import GeneratedSpectrum, loop, make
from tactogram.models.ultrasonic_cgan.figures import clusters_figure, selection_figure, spectra_figure
from tactogram.models.ultrasonic_cgan.pair import ClusterNetworks, TrainedCluster
from tactogram.models.ultrasonic_cgan.spectra import (
    SideSpectra,
    display_side,
    felt_features,
    sensor_side,
    sensor_spectra,
    signals_of,
    surfaces_of,
)
from tactogram.models.ultrasonic_cgan.surfaces import SurfaceTable
from tactogram.nn.score_regression import ScoreRegression
from tactogram.signal import Signal
from tactogram.training.seeds import child_rng

FIT = "fit"
Places = NDArray[np.int64]


class UltrasonicCGANLearner(Model):
    """CGANs of Sec. IV, one per cluster of the surfaces; ``kind`` is of display signals, surfaces are its materials."""

    config: Config
    kind: SignalKind

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        if not (kind.materials and kind.words and kind.scale):
            raise ParameterError("ultrasonic_cgan needs rated surfaces and rated signals, got none")
        if config.clusters > len(kind.materials):
            raise ParameterError.must(
                "clusters", f"be at most the {len(kind.materials)} surfaces", config.clusters
            )
        super().__init__(config, kind, seed=seed, device=device)
        self.pair = ClusterNetworks(config, words=len(kind.words), seed=seed, device=torch.device(device))
        self.surfaces: SurfaceTable | None = None
        self.trained: list[TrainedCluster] = []
        """Results of the finished clusters."""
        self._data: TrainingSpectra | None = None

    def parts(self) -> Sequence[Any]:
        return (self.pair,)

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        if not signals_of(examples):
            raise ParameterError("ultrasonic_cgan needs rated display signals, without a material; got none")
        self.kind.check_all_present(examples)
        steps = math.ceil(self.config.iterations / self.config.iterations_per_step)
        return Stage(FIT, 1), *(Stage(f"cluster-{k + 1}", steps) for k in range(self.config.clusters))

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        data = self._of(examples)
        if stage.name == FIT:
            yield (examples,)
            return
        surfaces, cluster = self._surfaces, _number(stage)
        rows = (surfaces.rows(data.sensor, cluster), np.arange(len(data.display.item)))
        if self.config.display_by_cluster:
            rows = (rows[0], surfaces.display_rows(data.display, cluster))
        data.move(surfaces, self.pair.device)
        self.pair.regression = data.regression() if self.config.words_weight else None
        each, batch = self.config.iterations_per_step, self.config.batch_size
        for step in range(start, stage.steps):
            rng = child_rng(seed, "batch", step)
            size = (min(each, self.config.iterations - step * each), batch)
            sensor, display = (rng.choice(some, size) for some in rows)
            raters = (
                rng.integers(0, data.sensor.raters[sensor]),
                rng.integers(0, data.display.raters[display]),
            )
            yield np.array(step), (sensor, raters[0]), (display, raters[1])

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == FIT:
            return self._fit(batch[0])
        if self._data is None:
            raise RuntimeError("a step needs batches: take them from `batches`")
        step, sensor, display = batch
        if step == 0:
            self.pair.begin(_number(stage))
        figures = self.pair.iterate(self._data.rows(0, *sensor), self._data.rows(1, *display))
        if step + 1 == stage.steps:
            self.trained.append(self._trained(self.pair.outcome()))
            chosen = self.trained[-1].chosen
            figures["failed"] = float(chosen is None)
            if chosen is not None:
                figures["chosen_iteration"] = float(chosen.iteration)
        return figures

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the surface table; refuses display signals that cannot be divided by cluster."""
        data = self._of(examples)
        self.surfaces = SurfaceTable.measured(data.sensor, data.display, self.config)
        if self.config.display_by_cluster:
            for cluster in range(self.config.clusters):
                self.surfaces.display_rows(data.display, cluster)
        self.trained = []
        return {
            "sensor_spectra": float(len(data.sensor.spectra)),
            "display_spectra": float(len(data.display.spectra)),
            "sensor_scores_filled": data.sensor.filled,
            "display_scores_filled": data.display.filled,
        }

    def _of(self, examples: Sequence[Example]) -> TrainingSpectra:
        if self._data is None or self._data.examples is not examples:
            signals = signals_of(examples)
            for example in signals:
                self.kind.check(example.signal)
            self._data = TrainingSpectra(
                examples,
                sensor_side(surfaces_of(examples), self.config, self.kind.materials),
                display_side(signals, self.config),
            )
        return self._data

    def _trained(self, outcome: Mapping[str, Any]) -> TrainedCluster:
        return TrainedCluster.of(outcome, self.config, words=len(self.kind.words), device=self.pair.device)

    @property
    def _surfaces(self) -> SurfaceTable:
        if self.surfaces is None:
            raise ParameterError("ultrasonic_cgan has not been trained: its surfaces are not measured")
        return self.surfaces

    @property
    def rated_means(self) -> dict[str, NDArray[np.float64]]:
        return dict(zip(self._surfaces.plates, self._surfaces.means, strict=True))

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the number of failed trainings, and figures of the others on unseen recordings: `figures_of`."""
        failed = {"failed_clusters": float(sum(pair.chosen is None for pair in self.trained))}
        by_plate: dict[int, list[NDArray[np.float32]]] = {}
        for example in surfaces_of(examples):
            if example.material in self.kind.materials:
                spectra = sensor_spectra(example.signal, self.config).reshape(-1, self.config.bins)
                by_plate.setdefault(self.kind.materials.index(example.material), []).append(spectra)
        spectra_of = {plate: np.concatenate(some) for plate, some in sorted(by_plate.items())}
        return failed | figures_of(spectra_of, self._surfaces, self.trained)

    def outcome(self) -> dict[str, Any]:
        surfaces, rule = self._surfaces, self.pair.rule
        clusters = [
            {
                "surfaces": list(surfaces.members(number)),
                "failed": pair.chosen is None,
                "chosen_iteration": pair.chosen and pair.chosen.iteration,
                "generator_loss": pair.chosen and pair.chosen.loss,
                "correct_rate_smoothed": pair.chosen and pair.chosen.rate,
                "iterations": pair.curves.shape[1],
            }
            for number, pair in enumerate(self.trained)
        ]
        return {
            "group": self.config.group,
            "linkage": f"{self.config.linkage}, Euclidean",
            "rule": f"smallest non-zero generator loss where the correct rate over the last {rule.window} iterations "
            f"is {rule.low:.0%} to {rule.high:.0%}"
            + (f", after iteration {rule.after}" if rule.after else ""),
            "clusters": clusters,
        }

    def figures(self) -> dict[str, Figure]:
        """Return the tree of the surfaces, the curves with the chosen iterations, and spectra in and out."""
        surfaces = self._surfaces
        data = "simulated data" if self.kind.simulated else ""
        names = [_cluster_title(number, surfaces.members(number)) for number in range(len(self.trained))]
        title = ", ".join(text for text in (self.config.group, data) if text)
        return {
            "clusters": clusters_figure(surfaces, method=self.config.linkage, title=title),
            "selection": selection_figure(self.trained, self.pair.rule, names, title=title),
            "spectra": spectra_figure(surfaces, self.trained, names, title=title),
        }

    def state(self) -> dict[str, Any]:
        return {
            "surfaces": self.surfaces and self.surfaces.state(),
            "trained": [pair.state() for pair in self.trained],
            "optimisers": self.pair.state(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if state["surfaces"] is not None:
            self.surfaces = SurfaceTable.of(state["surfaces"])
            check_state(self.surfaces.plates, self.kind.materials)
        self.trained = [self._trained(saved) for saved in state["trained"]]
        if "optimisers" in state:
            self.pair.load_state(state["optimisers"])

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return the modulating signal for scores: a loop of 1 s without a seam, repeated for ``seconds``.

        The last repetition is cut if ``seconds`` is no whole number. Each axis of the display has the same spectrum in
        other phases.

        ``condition`` has ``words``, a score for each word of the run, on the scale of its ratings, and may have
        ``vibration``, a Signal of a sensor, 1 s or longer, of which ``seed`` draws an axis and a window; by default a
        stored spectrum, also drawn, of the surface nearest in words.

        Raises `ParameterError` if a word is missing or unknown, a score off the scale, or the vibration too short or
        constant; `FailedTrainingError` if the training of the cluster of the nearest surface failed.
        """
        spectrum = self._make(condition, seed)
        return loop(spectrum.amplitudes, self.kind, self.config, seconds=seconds, seed=seed)

    def selection_for(self, condition: Condition, seed: int) -> dict[str, Any]:
        """Return the inputs of `generate` and the clamped shares, as JSON values.

        Keys of the result: ``surface`` (nearest in words), ``distance`` (of the scores as 0 to 1, Euclidean),
        ``group``, ``cluster`` (from 1), ``cluster_surfaces``, ``sensor_spectrum`` (``recording``, ``axis``,
        ``window``), ``clamped_bins`` and ``clamped_amplitude`` (shares below 0), ``nearest_display_signal`` and
        ``nearest_display_distance`` (a small one is a copy), ``full_scale`` (1: the limit of the display's drive),
        ``peak``, ``crest_factor``.
        """
        spectrum = self._make(condition, seed)
        signal = loop(spectrum.amplitudes, self.kind, self.config, seconds=None, seed=seed)
        return spectrum.facts(self._surfaces, self.config, signal)

    def _make(self, condition: Condition, seed: int) -> GeneratedSpectrum:
        return make(condition, self._surfaces, self.trained, self.kind, self.config, seed=seed)


class TrainingSpectra:
    """Spectra of the training part, and tables of them on the device."""

    def __init__(self, examples: Sequence[Example], sensor: SideSpectra, display: SideSpectra) -> None:
        self.examples, self.sensor, self.display = examples, sensor, display
        self._tables: tuple[tuple[Tensor, Tensor, Tensor], ...] = ()

    def move(self, surfaces: SurfaceTable, device: torch.device) -> None:
        """Move scaled spectra and scores to ``device``, once."""
        if not self._tables:
            sides = ((self.sensor, surfaces.sensor_scale), (self.display, surfaces.display_scale))
            self._tables = tuple(
                (
                    torch.from_numpy(side.spectra / np.float32(scale)).to(device),
                    torch.from_numpy(side.item).to(device),
                    torch.from_numpy(side.table).to(device),
                )
                for side, scale in sides
            )

    def rows(self, side: int, places: Places, raters: Places) -> Tensor:
        """Return spectra of a side, 0 sensor or 1 display, with scores: (iteration, batch, bin + word)."""
        spectra, item, scores = self._tables[side]
        at, by = (torch.from_numpy(some).to(spectra.device) for some in (places, raters))
        return torch.cat((spectra[at], scores[item[at], by]), 2)

    def regression(self) -> ScoreRegression:
        """Return the regression from the display signals to their mean scores."""
        spectra, item, _ = self._tables[1]
        return ScoreRegression(felt_features(spectra), torch.from_numpy(self.display.means).to(spectra)[item])


build = UltrasonicCGANLearner


def _cluster_title(number: int, members: Sequence[str]) -> str:
    shown = ", ".join(members) if len(members) < 6 else f"{members[0]} … {members[-1]} ({len(members)})"
    return f"cluster {number + 1}: {shown}"


def _number(stage: Stage) -> int:
    return int(stage.name.removeprefix("cluster-")) - 1
