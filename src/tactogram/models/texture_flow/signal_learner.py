"""Signals: training on crops of whitened spectra; textures of any length and of mixed materials."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.photo_classifier import PhotoClassifier, distinct_photographs
from tactogram.features.signal_crops import SignalCrops
from tactogram.model import (
    WHOLE_BATCH,
    BatchShare,
    Condition,
    Example,
    ExportedNetwork,
    SignalKind,
    Stage,
    check_condition,
    check_state,
)
from tactogram.models import shipped_run
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.exported import (
    exported_flow,
    exported_predictor,
    exported_recovery,
)
from tactogram.models.texture_flow.flow_model import FlowModel
from tactogram.models.texture_flow.known_surfaces import DESCRIPTIONS, OF_THE_VIBRATION, KnownSurfaces
from tactogram.models.texture_flow.modulation import modulated
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.models.texture_flow.surface_prediction import (
    UNKNOWN,
    Reference,
    StrokePair,
    Strokes,
    SurfacePredictor,
)
from tactogram.models.texture_flow.surfaces import LEAST_DEVIATION, Surface, SurfaceSpectra
from tactogram.models.texture_flow.tonal_surfaces import split_strokes
from tactogram.nn.bare_and_fixed import bare
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.signal import Image, Signal
from tactogram.signal.displacement import played
from tactogram.signal.motion import Motion
from tactogram.signal.tone_synthesis import synthesise_tones
from tactogram.training.checkpoint import load_state
from tactogram.training.seeds import child_generator, child_rng, child_seed, torch_seeded

NOISE_FRAMES = 64
"""Frames of noise that are drawn at once, so that longer signals begin with the same noise."""
LARGEST_CODE = 4.0
"""Numbers of a code count as at most so many standard deviations of those of the recordings."""
MOST_PHOTOGRAPHS = 50
"""Photographs of a material that are learned from."""
UNSEEN_CROPS = 64
"""Crops of unseen recordings that the loss is measured on."""
MOMENT_S = 0.05
"""Longest time between two moments of a motion for which a surface is determined, s."""
PLAYBACK_RATE = 4000.0
"""Of a signal over displacement that is played at a speed, Hz."""
LEAST_ITERATIONS = 2
"""Of phase recovery, for it to be exported."""
LEAST_RMS = 1e-12
"""Of a vibration in another unit."""


class SignalFlowLearner:
    """Whitened spectra, and the flow that generates them."""

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        self.config, self.kind, self.seed, self.materials = config, kind, seed, kind.materials
        self.device, self.share = torch.device(device), WHOLE_BATCH
        self.spectra = SurfaceSpectra(config, kind.rate, kind.domain)
        self.codes = torch.zeros(2, self.spectra.code_size(len(kind.axes)))
        """Mean and standard deviation of the codes of recordings."""
        self.over_displacement = kind.domain == "displacement"
        conditions = [
            name for name in config.conditions if name != "speed_mm_s" or not self.over_displacement
        ]
        self.labels = Labels(conditions)
        self.label_size = self.codes.shape[1] + 2 + 4 * len(conditions)
        with torch_seeded(seed, "weights"):
            network = VelocityUNet(config, channels=len(kind.axes), labels=self.label_size)
        self.flow = FlowModel(network, config, device=self.device)
        predictor = None
        if config.prediction_steps:
            with torch_seeded(seed, "predictor"):
                predictor = SurfacePredictor(
                    self.spectra.vector_size(len(kind.axes)),
                    components=config.components,
                    conditions=conditions,
                    words=len(kind.words),
                ).to(self.device)
        self.known = KnownSurfaces(kind, self.spectra, self.labels, predictor)
        self.seconds = self.rms = 0.0
        """Medians of the training recordings (mm over displacement instead of seconds)."""
        self.backward: Callable[[Tensor], None] = Tensor.backward

    @cached_property
    def prediction_optimiser(self) -> Any:
        """AdamW."""
        return torch.optim.AdamW(self.known.predictor.parameters(), lr=self.config.learning_rate)

    def setup(self, fabric: Any) -> None:
        self.flow.setup(fabric)
        if self.known.predictor is not None:
            self.known.predictor, self.prediction_optimiser = fabric.setup(
                self.known.predictor, self.prediction_optimiser
            )
            self.known.predictor.mark_forward_method("loss")
        self.backward, self.device = fabric.backward, fabric.device
        self.share = BatchShare.of_process(fabric)

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.kind.require_materials("texture_flow")
        self.kind.check_all_present(examples)
        predict = (
            (Stage("predict", self.config.prediction_steps),) if self.known.predictor is not None else ()
        )
        return Stage("fit", 1), *predict, *self.flow.stages

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
            return
        examples = modulated(self._without_tones(examples), self.config.modulated, seed=self.seed)
        measured = self._measured(examples)
        step = start
        if stage.name == "predict":
            several = [found for found in measured.values() if len(found) > 1]
            if not several:
                raise ParameterError(
                    "config.prediction_steps needs several recordings of a material; set it to 0"
                )
            strokes = Strokes.of(several, bare(self.known.predictor))
            while True:
                rng = child_rng(seed, "pairs", step, *self.share.purpose)
                yield step, strokes.pairs(self.share.size(self.config.prediction_batch), rng)
                step += 1
        crops = self._crops(examples)
        while True:
            yield (
                step,
                *self._batch(crops, measured, step, self.config.batch_size, seed=seed, share=self.share),
            )
            step += 1

    def _crops(self, examples: Sequence[Example]) -> SignalCrops:
        length = self.spectra.samples(self.config.frames)
        return SignalCrops(examples, length, overlap=self.spectra.transform.n_fft)

    def _without_tones(self, examples: Sequence[Example]) -> Sequence[Example]:
        """Return recordings without their tones; as they are, where surfaces are predicted, lines included."""
        if self.known.predictor is not None:
            return examples
        found = list(examples)
        names = [str(example.material) for example in examples]
        for material in dict.fromkeys(names):
            places = [place for place, name in enumerate(names) if name == material]
            for place, rest in zip(places, split_strokes([found[p] for p in places])[1], strict=True):
                found[place] = rest
        return found

    def _measured(self, examples: Sequence[Example]) -> dict[str, list[Reference]]:
        """Return the surface of each recording that is long enough, by material."""
        found: dict[str, list[Reference]] = {str(example.material): [] for example in examples}
        unknown = torch.full((len(self.kind.words),), torch.nan)
        for example in examples:
            surface = self.spectra.measure([example.signal])
            if surface is not None:
                rated = example.rated if self.kind.words else None
                words = unknown if rated is None else torch.from_numpy(rated.means).float()
                found[str(example.material)].append(Reference(example.id, surface, example.condition, words))
        return found

    def _batch(
        self,
        crops: SignalCrops,
        measured: Mapping[str, Sequence[Reference]],
        number: int,
        count: int,
        *,
        seed: int,
        share: BatchShare = WHOLE_BATCH,
    ) -> tuple[Tensor, Tensor]:
        """Return a share of a batch: spectra of crops, (crop, axis, bin, frame), and their labels, (crop, label).

        The surface of a crop is that of its material, or of another recording of it alone; of its own recording where
        surfaces are predicted at its speed and force: as these are taken for true in use, they are in training.
        """
        rng = child_rng(seed, "references", number, *share.purpose)
        numbers = share.places(np.arange(number * count, (number + 1) * count), count)
        known = dict(zip(self.materials, self.known.surfaces, strict=True))
        spectra, labels = [], []
        for example, crop in crops.at(numbers.tolist(), partial(child_rng, seed)):
            material = str(example.material)
            reference: Condition | None = None
            wanted = example.condition
            others = [found for found in measured[material] if found.id != example.id]
            own = [found for found in measured[material] if found.id == example.id]
            if self.known.predictor is not None and own:
                surface = own[0].surface
                wanted = reference = {} if rng.random() < UNKNOWN else wanted
            elif others and (material not in known or rng.random() < self.config.references):
                other = others[rng.integers(len(others))]
                surface, reference = other.surface, other.condition
            else:
                surface = known[material]
            spectra.append(self.spectra.encode(crop, surface))
            labels.append(self._label(surface, wanted, reference))
        return torch.stack(spectra), torch.stack(labels)

    def _label(self, surface: Surface, condition: Condition, measured: Condition | None) -> Tensor:
        """Return the code of a surface, a 1, and speed and force that it was measured with; then those wanted.

        Float32, shape (label,); after speeds and forces are as many numbers, 1 for each that is known. ``measured`` is
        the condition of the one recording that the surface was measured from, if it was one: another 1.
        """
        code = (surface.code - self.codes[0]) / self.codes[1].clamp_min(LEAST_DEVIATION)
        measures = float(measured is not None), *self._numbers(measured or {})
        numbers = torch.tensor([1.0, *measures, *self._numbers(condition)])
        return torch.cat((code.clamp(-LARGEST_CODE, LARGEST_CODE), numbers))

    def _numbers(self, condition: Condition) -> list[float]:
        known = [
            float(name in self.labels.ranges and condition.get(name) is not None)
            for name in self.labels.names
        ]
        return [*self.labels.numbers(condition), *known]

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(batch)
        if stage.name == "predict":
            return self._step_of_prediction(stage, *batch)
        number, spectra, label = batch
        return {"loss": self.flow.step(stage, number, spectra, self._with_some_dropped(label))}

    def _step_of_prediction(self, stage: Stage, number: int, pairs: StrokePair) -> dict[str, float]:
        self.known.predictor.train()
        for group in self.prediction_optimiser.param_groups:
            group["lr"] = self.config.learning_rate * (1 + math.cos(math.pi * number / stage.steps)) / 2
        loss = self.known.predictor.loss(StrokePair(*(tensor.to(self.device) for tensor in pairs)))
        self.prediction_optimiser.zero_grad()
        self.backward(loss)
        self.prediction_optimiser.step()
        self.known.predictor.eval()
        return {"loss": loss.item()}

    def _with_some_dropped(self, label: Tensor) -> Tensor:
        """Return labels, (batch, label), of which some lack the surface, others speed and force."""
        wanted = 2 * len(self.labels.names)
        kept = (torch.rand(len(label), 2) >= self.config.dropped).float()
        return label * kept.repeat_interleave(torch.tensor([label.shape[1] - wanted, wanted]), dim=1)

    def _fit(self, examples: Sequence[Example]) -> dict[str, float]:
        if self.config.start:
            self._start_from(shipped_run(self.config.start) or Path(self.config.start))
        self.labels.fit(examples)
        members = self.kind.by_material(examples)
        split = {name: split_strokes(members[name]) for name in self.materials}
        self.known.tones = [split[name][0] for name in self.materials]
        self.known.surfaces = [
            self.known.measured(name, [example.signal for example in split[name][1]])
            for name in self.materials
        ]
        noise = [example for _, rest in split.values() for example in rest]
        trained_on = noise if self.known.predictor is None else examples
        self.known.rate([members[name] for name in self.materials])
        measured = self._measured(modulated(trained_on, self.config.modulated, seed=self.seed)).values()
        codes = torch.stack([reference.surface.code for references in measured for reference in references])
        self.codes = torch.stack((codes.mean(0), codes.std(0, correction=0)))
        if self.known.predictor is not None:
            self._fit_predictor(Strokes.of([*measured], bare(self.known.predictor)))
            self.known.strokes = self._strokes_of(noise, self.materials)
        if self.config.photographs:
            self.known.photographs.fit(
                {name: distinct_photographs(members[name], MOST_PHOTOGRAPHS) for name in self.materials},
                child_rng(self.seed, "photographs"),
            )
        self.seconds = float(np.median([len(example.signal) / example.signal.rate for example in examples]))
        self.rms = float(np.median([_rms(example.signal) for example in examples]))
        return {"seconds": self.seconds}

    def _start_from(self, run: Path) -> None:
        """Take over the average weights of another run, those before it was straightened."""
        state = load_state(run / "model.safetensors")[0]
        weights = state.get("teacher") or state.get("average", {}).get("weights", {})
        try:
            self.flow.start_from(weights)
        except RuntimeError as error:
            raise ParameterError(
                f"config.start must be a run of texture_flow of {len(self.kind.axes)} axes, {self.spectra.bins} bins "
                f"and widths {self.config.widths}; {run} is not"
            ) from error

    def _fit_predictor(self, strokes: Strokes) -> None:
        predictor = bare(self.known.predictor)
        if strokes.at.isnan().any(0).all():
            raise ParameterError(
                f"config.prediction_steps needs the {' or '.join(predictor.conditions)} of every recording; set it to 0"
            )
        predictor.fit(strokes.vectors, strokes.at, strokes.words)
        predictor.eval()

    def _strokes_of(self, examples: Sequence[Example], materials: Sequence[str]) -> Strokes:
        measured = self._measured(examples)
        return Strokes.of([measured[name] for name in materials], bare(self.known.predictor))

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the loss on unseen crops; well above that of the training crops if these were memorised."""
        examples = self._without_tones(examples)
        measured = self._measured(examples)
        examples = [e for e in examples if e.material in self.materials or len(measured[str(e.material)]) > 1]
        if not examples:
            return {}
        count = max(len(examples), UNSEEN_CROPS)
        spectra, label = self._batch(self._crops(examples), measured, 0, count, seed=0)
        return {"loss_unseen": self.flow.loss(spectra, label)}

    def state(self) -> dict[str, Any]:
        return {
            "materials": list(self.materials),
            "seconds": self.seconds,
            "rms": self.rms,
            "codes": self.codes,
            **self.known.state(),
            "conditions": self.labels.state(),
            **self.flow.state(),
            "optimisers": [optimiser.state_dict() for optimiser in self._optimisers],
        }

    def state_with_materials(self, examples: Sequence[Example]) -> dict[str, Any]:
        """Return the state of a model that knows the materials of other recordings instead, as it is shipped."""
        names = ("seconds", "rms", "codes", "conditions", "average", "teacher", "predictor")
        materials = tuple(dict.fromkeys(str(example.material) for example in examples))
        split = [split_strokes([e for e in examples if e.material == name]) for name in materials]
        noise = [example for _, rest in split for example in rest]
        others: dict[str, Any] = {"surfaces": [], "photographs": PhotoClassifier(materials).state()}
        others |= {"materials": list(materials), "strokes": self._strokes_of(noise, materials).state()}
        others |= {"tones": [[tones.state() for tones in patterns] for patterns, _ in split]}
        return {name: value for name, value in self.state().items() if name in names} | others

    @property
    def _optimisers(self) -> list[Any]:
        return [self.flow.optimiser, *([] if self.known.predictor is None else [self.prediction_optimiser])]

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(state["materials"], self.materials)
        self.seconds, self.rms = float(state["seconds"]), float(state["rms"])
        self.codes = state["codes"]
        self.known.load_state(state)
        self.labels.load_state(state["conditions"])
        self.flow.load_state(state)
        if saved := state.get("optimisers"):
            for optimiser, own in zip(self._optimisers, saved, strict=True):
                optimiser.load_state_dict(own)

    # -- export ------------------------------------------------------------------------------------------

    def exported_networks(self) -> dict[str, ExportedNetwork]:
        config, kind = self.config, self.kind
        labels = {name: self._label_of({"material": name}).tolist() for name in self.materials}
        found = exported_flow(
            self.flow,
            (len(kind.axes), self.spectra.bins, config.frames),
            (config.frames, self.label_size),
            axes=("batch", "axis", "bin", "frame"),
            output="log magnitudes of the surface's sources, standardised",
            free=("frame",),
            facts={"label": labels, "frame_multiple": config.multiple},
        )
        if self.spectra.iterations >= LEAST_ITERATIONS:
            frames = self.spectra.frames(round(self.seconds * kind.rate), config.multiple)
            found["phase_recovery"] = exported_recovery(self.spectra, frames, kind.unit)
        if self.known.predictor is not None:
            found["predictor"] = exported_predictor(bare(self.known.predictor))
        return found

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal, by default as long as the median of the training recordings.

        The surface is a material or mix, with weights scaled to sum to 1; the materials of a photograph, mixed by their
        probabilities; that of a measured vibration; or that which scores of words describe, of which some may be
        missing. Of a mix cross-spectra, log magnitudes and codes are mixed. Beyond the recorded range, speed and force
        count as the nearest recorded ones. A vibration in another unit counts as loud as the training recordings, and
        the result is in its unit.

        Trained on signals over displacement, it returns one, or with ``speed_mm_s`` or a ``motion`` that signal as
        felt at this speed, over time, for ``seconds``, which need a speed.

        Trained with ``config.prediction_steps``, it predicts surfaces at the speed and force wanted: a material's from
        its strokes, or that of a vibration, more accurately with ``vibration_speed_mm_s`` and ``vibration_force_n``,
        those that it was measured with. So is the surface of words, if surfaces were rated; without such a training it
        is a mix of those rated alike (`word_weights`).

        A ``motion`` changes speed and force over time, as far as the training recordings have them, and silences the
        signal where its gain is 0; over displacement, where the finger is lifted. The signal is as long as the motion.
        """
        check_condition(condition, takes=(*DESCRIPTIONS, *NUMBERS, "motion", *OF_THE_VIBRATION))
        motion = condition.get("motion")
        if motion is not None and not isinstance(motion, Motion):
            raise ParameterError(f"motion must be a Motion, got {type(motion).__name__}")
        vibration = condition.get("vibration")
        if vibration is not None and vibration.unit != self.kind.unit:
            gain = self.rms / max(_rms(vibration), LEAST_RMS)
            alike = vibration.with_samples(gain * vibration.samples, unit=self.kind.unit)
            made = self.generate({**condition, "vibration": alike}, seconds=seconds, seed=seed)
            return made.with_samples(made.samples / gain, unit=vibration.unit)
        if self.over_displacement:
            return self._over_displacement(condition, seconds, seed=seed)
        return self.kind.signal(self._samples(condition, seconds, seed=seed))

    def _over_displacement(self, condition: Condition, seconds: float | None, *, seed: int) -> Signal:
        """Return a signal over displacement, or as it is felt at a speed or along a motion."""
        motion: Motion | None = condition.get("motion")
        speed: float | None = condition.get("speed_mm_s")
        still = {**condition, "speed_mm_s": None, "motion": None}
        if motion is not None:
            if speed is not None:
                raise _given_twice(["speed_mm_s"])
            times = np.arange(0, motion.lasting(seconds), 1 / PLAYBACK_RATE)
            moved = np.interp(times, motion.time_s, motion.speed_mm_s)
            length_mm = float(np.sum(moved) + 2 * np.max(moved)) / PLAYBACK_RATE + 2 / self.kind.rate
            made = self.kind.signal(self._samples(still, length_mm, seed=seed))
            speeds = Signal((1e-3 * moved[None]).astype(np.float32), PLAYBACK_RATE, "m/s", ("along",))
            felt = played(made, speeds, PLAYBACK_RATE)
            contact = motion.at("contact", np.arange(len(felt)) / PLAYBACK_RATE)
            return felt if contact is None else felt.with_samples((felt.samples * contact).astype(np.float32))
        if speed is None:
            if seconds is not None:
                raise ParameterError(
                    "seconds of a signal over displacement need a speed: give speed_mm_s, or omit them"
                )
            return self.kind.signal(self._samples(still, None, seed=seed))
        if not (math.isfinite(speed) and speed > 0):
            raise ParameterError(f"speed_mm_s must be > 0, got {speed}")
        made = self.kind.signal(self._samples(still, None if seconds is None else seconds * speed, seed=seed))
        return played(made, speed, PLAYBACK_RATE)

    def _samples(self, condition: Condition, seconds: float | None, *, seed: int) -> NDArray[np.float32]:
        """Return the samples of a condition that is at constant speed and force or has a motion, (axis, time)."""
        motion: Motion | None = condition.get("motion")
        if motion is not None:
            seconds = motion.lasting(seconds)
        elif seconds is None:
            seconds = self.seconds
        moments = [condition] if motion is None else self._moments(condition, motion, seconds)
        for moment in moments:
            self.labels.check(moment)
        at = self.known.described(condition, draw=child_rng(seed, "tones").random())
        found = [at(moment) for moment in moments]
        labels = [
            self._label_at(moment, each.surface, reached)
            for moment, (each, reached) in zip(moments, found, strict=True)
        ]
        length = max(1, round(seconds * self.kind.rate))
        spectrum = self._spectrum(torch.stack(labels), length, seed=seed)
        noise = self.spectra.decode(spectrum.cpu(), [each.surface for each, _ in found], length, seed=seed)
        steady = synthesise_tones(
            [each.tones for each, _ in found], length, self.kind.rate, seed=child_seed(seed, "tones")
        )
        samples = noise + steady
        if motion is not None and motion.gain is not None:
            mean = found[0][0].surface.mean.numpy()[:, None]
            samples = mean + motion.at("gain", np.arange(length) / self.kind.rate) * (samples - mean)
        return samples.astype(np.float32)

    def _label_at(self, moment: Condition, surface: Surface, reached: Condition | None) -> Tensor:
        """Return the label of a surface that is known at the condition ``reached``, wanted at ``moment``."""
        wanted = moment if self.known.predictor is None or reached is None else reached
        return self._label(surface, wanted, reached)

    def _label_of(self, condition: Condition) -> Tensor:
        """Return the label of a condition without a motion."""
        found, reached = self.known.described(condition, draw=0.5)(condition)
        return self._label_at(condition, found.surface, reached)

    def _moments(self, condition: Condition, motion: Motion, seconds: float) -> list[Condition]:
        """Return the condition at evenly spaced times of a motion, at most `MOMENT_S` apart."""
        times = np.linspace(0, seconds, 2 + int(seconds / MOMENT_S))
        known = {
            name: values
            for name in NUMBERS
            if name in self.labels.ranges and (values := motion.at(name, times)) is not None
        }
        if "speed_mm_s" not in known:
            raise ParameterError(
                "this run was trained on recordings of unknown speed, so it cannot follow a motion"
            )
        if twice := [name for name in known if condition.get(name) is not None]:
            raise _given_twice(twice)
        return [
            {**condition, **{name: float(values[k]) for name, values in known.items()}}
            for k in range(len(times))
        ]

    @property
    def predicted_ranges(self) -> dict[str, tuple[float, float]]:
        if self.known.strokes is None:
            return {}
        return {name: (known.least, known.most) for name, known in self.labels.ranges.items()}

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        probabilities = self.known.photographs.probabilities(image)
        return self.materials[probabilities.argmax()], float(probabilities.max())

    def _spectrum(self, labels: Tensor, length: int, *, seed: int) -> Tensor:
        """Return a spectrum, (axis, bin, frame), of at least ``length`` samples.

        Several labels, (moment, label), are those at evenly spaced times from the first sample to the last.
        """
        frames = self.spectra.frames(length, self.config.multiple)
        shape = len(self.kind.axes), self.spectra.bins, NOISE_FRAMES
        noise = torch.cat(
            [
                torch.randn(shape, generator=child_generator(seed, "noise", number))
                for number in range(-(-frames // NOISE_FRAMES))
            ],
            -1,
        )[None, ..., :frames]
        over_frames = self.spectra.over_frames(labels, frames, length)
        return self.flow.sample(noise, over_frames[None])[0]


def _given_twice(names: Sequence[str]) -> ParameterError:
    return ParameterError(
        f"the motion has its own {' and '.join(names)}; omit {'it' if len(names) == 1 else 'them'}"
    )


def _rms(signal: Signal) -> float:
    return float(np.sqrt(np.mean(np.var(signal.samples, axis=1, dtype=np.float64))))
