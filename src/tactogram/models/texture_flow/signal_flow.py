"""Signals from whitened spectra: textures of any length and of mixed materials, at rest or along a motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, Limit, SignalKind, check_condition, limits_within, word_limits
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.flow_model import FlowLearner, FlowModel
from tactogram.models.texture_flow.known_surfaces import DESCRIPTIONS, OF_THE_VIBRATION, KnownSurfaces
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.models.texture_flow.surface_prediction import SurfacePredictor
from tactogram.models.texture_flow.surfaces import LEAST_DEVIATION, Surface, SurfaceSpectra
from tactogram.nn.labels import NUMBERS, Labels
from tactogram.signal import Image, Signal
from tactogram.signal.displacement import played
from tactogram.signal.local_amplitudes import with_local_quantiles
from tactogram.signal.motion import Motion
from tactogram.signal.tones import synthesise_tones
from tactogram.training.seeds import child_generator, child_rng, child_seed, torch_seeded

NOISE_FRAMES = 64
"""Frames of noise that are drawn at once, so that longer signals begin with the same noise."""
LARGEST_CODE = 4.0
"""Numbers of a code count as at most so many standard deviations of those of the recordings."""
MOMENT_S = 0.05
"""Longest time between two moments of a motion for which a surface is determined, s."""
PLAYBACK_RATE = 4000.0
"""Of a signal over displacement that is played at a speed, Hz."""
LEAST_RMS = 1e-12
"""Of a vibration in another unit."""


class SignalFlow(FlowLearner):
    """Whitened spectra, the flow that generates them, and the surfaces whose spectra they are."""

    config: Config
    kind: SignalKind

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        super().__init__(config, kind, seed=seed, device=device)
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
        self.flow = FlowModel(network, config, device=torch.device(device))
        predictor = None
        if config.prediction:
            predictor = SurfacePredictor(
                self.spectra.vector_size(len(kind.axes)),
                components=config.components,
                conditions=(*conditions, "contactor"),
                words=len(kind.words),
            )
        self.known = KnownSurfaces(kind, self.spectra, self.labels, predictor)
        self.seconds = self.rms = 0.0
        """Medians of the training recordings (mm over displacement instead of seconds)."""

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

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal, by default as long as the median of the training recordings.

        The surface is a material or mix, with weights scaled to sum to 1; predicted from a photograph, a text or both,
        and words with them (`DescribedSurfaces`); that of a measured vibration; or that which scores of words describe,
        of which some may be missing. Of a mix cross-spectra, log magnitudes and codes are mixed. Beyond the recorded
        range, speed and force count as the nearest recorded ones. A vibration in another unit counts as loud as the
        training recordings, and the result is in its unit.

        Trained on signals over displacement, it returns one, or with ``speed_mm_s`` or a ``motion`` that signal as
        felt at this speed, over time, for ``seconds``, which need a speed.

        Trained with ``config.prediction``, it predicts surfaces at the speed, force and contactor wanted: a material's
        from its strokes, or that of a vibration, given ``vibration_speed_mm_s``, ``vibration_force_n`` and
        ``vibration_contactor``, those that it was measured with: one not given counts as the mean in training. So is
        the surface of words, if surfaces were rated; without such a training it is a mix of those rated alike
        (`word_weights`).

        A ``motion`` changes speed and force over time, as far as the training recordings have them, and silences the
        signal where its gain is 0; over displacement, where the finger is lifted. The signal is as long as the motion.
        """
        check_condition(condition, takes=(*DESCRIPTIONS, *NUMBERS, "contactor", "motion", *OF_THE_VIBRATION))
        self.known.check_contactors(condition)
        vibration = condition.get("vibration")
        if vibration is not None and vibration.unit != self.kind.unit:
            gain = self.rms / max(rms(vibration), LEAST_RMS)
            alike = vibration.with_samples(gain * vibration.samples, unit=self.kind.unit)
            signal = self.generate({**condition, "vibration": alike}, seconds=seconds, seed=seed)
            return signal.with_samples(signal.samples / gain, unit=vibration.unit)
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
            raw = self.kind.signal(self._samples(still, length_mm, seed=seed))
            speeds = Signal((1e-3 * moved[None]).astype(np.float32), PLAYBACK_RATE, "m/s", ("along",))
            felt = played(raw, speeds, PLAYBACK_RATE)
            contact = motion.at("contact", np.arange(len(felt)) / PLAYBACK_RATE)
            return felt if contact is None else felt.with_samples((felt.samples * contact).astype(np.float32))
        if speed is None:
            if seconds is not None:
                raise ParameterError(
                    "seconds of a signal over displacement need a speed: give speed_mm_s, or omit them"
                )
            return self.kind.signal(self._samples(still, None, seed=seed))
        if not (math.isfinite(speed) and speed > 0):
            raise ParameterError.must("speed_mm_s", "be > 0", speed)
        raw = self.kind.signal(self._samples(still, None if seconds is None else seconds * speed, seed=seed))
        return played(raw, speed, PLAYBACK_RATE)

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
        source = self.known.described(condition, draw=child_rng(seed, "tones").random())
        surfaces, reached = zip(*(source.at(moment) for moment in moments), strict=True)
        labels = [
            self._label_at(moment, each.surface, of)
            for moment, each, of in zip(moments, surfaces, reached, strict=True)
        ]
        length = max(1, round(seconds * self.kind.rate))
        spectrum = self._spectrum(torch.stack(labels), length, seed=seed)
        noise = self.spectra.decode(spectrum.cpu(), [each.surface for each in surfaces], length, seed=seed)
        mean = surfaces[0].surface.mean.numpy()[:, None]
        # A network's noise is smoother than touch: its samples get the clicks and pauses that were recorded.
        if (local := surfaces[0].local) is not None:
            noise = (mean + with_local_quantiles(noise - mean, self.kind.rate, local)).astype(np.float32)
        steady = synthesise_tones(
            [each.tones for each in surfaces], length, self.kind.rate, seed=child_seed(seed, "tones")
        )
        samples = noise + steady
        if motion is not None and motion.gain is not None:
            samples = mean + motion.at("gain", np.arange(length) / self.kind.rate) * (samples - mean)
        return samples.astype(np.float32)

    def _label_at(self, moment: Condition, surface: Surface, reached: Condition | None) -> Tensor:
        """Return the label of a surface that is known at the condition ``reached``, wanted at ``moment``."""
        condition = moment if self.known.predictor is None or reached is None else reached
        return self._label(surface, condition, reached)

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
        return {} if self.known.strokes is None else self.labels.limited

    def limits(self, condition: Condition) -> list[Limit]:
        words = word_limits(condition.get("words") or {}, self.kind, self.known.scores)
        return [*limits_within(condition, self.labels.limited), *words]

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        likely = self.known.described_by.recognised(image)
        return self.materials[likely.argmax()], float(likely.max())

    def prediction_facts(self, condition: Condition) -> dict[str, Any]:
        prediction = self.known.prediction(condition)
        return {} if prediction is None else prediction[1]

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


def rms(signal: Signal) -> float:
    """Return the root mean square of a signal whose axes have mean 0."""
    return float(np.sqrt(np.mean(np.var(signal.samples, axis=1, dtype=np.float64))))
