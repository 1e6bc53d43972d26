"""Stimuli of a study as signals, drives and pictures: read, generated or simulated, and hashed."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import tactogram_playback as playback
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.models import shipped_run
from tactogram.rendering import Display, Drive, Level, display_family, fit, open_display, parse_level, shipped
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_image_metadata, read_metadata, read_signal
from tactogram_study.stimuli import Stimulus
from tactogram_study.study_file import Study
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.simulated_stimuli import (
    autoregressive_signal,
    image_family,
    reconstruction,
    simulated_image,
    simulated_signal,
    simulated_surface,
)
from tactogram_study.workflows.streams import (
    StimulusStream,
    stimulus_stream,
    texture_of_signal,
    texture_settings,
)

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

SHOWN = 8
"""Lines on what is limited."""


@dataclass(frozen=True)
class SlotPlayback:
    """Drive or stream to play for one slot of a page; neither for silence, whose hash is that of nothing."""

    drive: Drive | None
    sha256: str
    level: str
    display: str
    gain_db: float = 0.0
    stream: StimulusStream | None = None

    @property
    def logged(self) -> dict[str, Any]:
        """What the session's log keeps of it, as `SessionStore.log_played` takes it."""
        names = ("sha256", "level", "display", "gain_db")
        return {name: getattr(self, name) for name in names}


class StudyStimuli:
    """Stimuli of one study, with a cache of signals and drives.

    Paths in the study are relative to ``folder``. On a server, whose studies may come from anybody, files, runs and
    displays must be in one of the folders ``within``, links followed; by default anywhere.
    """

    def __init__(self, study: Study, folder: Path, *, within: Sequence[Path] = ()) -> None:
        self.study, self.folder = study, folder
        self._within = tuple(path.resolve() for path in within)
        self._signals: dict[str, Signal] = {}
        self._drives: dict[tuple[str, float], SlotPlayback] = {}
        self._streams: dict[tuple[str, float], StimulusStream] = {}
        self._simulated: dict[str, bool] = {}
        self._limited: dict[str, list[str]] = {}

    def signal(self, stimulus: Stimulus) -> Signal:
        """Return the signal of a stimulus, before it is rendered.

        Raises `ParameterError` if it has none, or the generator or simulator refuses it; `DataError` if its file is
        missing or not readable.
        """
        if stimulus.name not in self._signals:
            with _named(stimulus):
                self._signals[stimulus.name] = self._make_signal(stimulus)
        return self._signals[stimulus.name]

    def played(self, presented: PresentedStimulus) -> SlotPlayback:
        """Return the drive of a presented stimulus, at its level and gain; its stream in a study that streams.

        Raises `TactogramError` if the display refuses the signal or the level; the message names the stimulus.
        """
        stimulus = presented.stimulus
        if stimulus is None:
            return SlotPlayback(None, hashlib.sha256(b"").hexdigest(), "", self.study.display)
        key = (stimulus.name, presented.gain_db)
        if key not in self._drives:
            streams = self.study.played_by == "stream"
            make = self._streamed if streams else self._rendered
            self._drives[key] = make(stimulus, presented.gain_db)
        return self._drives[key]

    def image(self, stimulus: Stimulus) -> Image | None:
        """Return the picture of a stimulus, None if it has none."""
        if stimulus.simulated_image:
            return simulated_image(stimulus.simulated_image, stimulus.seed)
        if stimulus.image_run:
            content = self._generated(stimulus, stimulus.image_run)
            if not isinstance(content, Image):
                problem = f"{stimulus.image_run} generates signals; give it as run"
                raise ParameterError(stimulus_place(stimulus.name), problem)
            return content
        return read_image(self._file(stimulus.image)) if stimulus.image else None

    def is_simulated(self, stimulus: Stimulus) -> bool:
        """Return whether any of a stimulus is simulated.

        Its source is a simulation, the metadata of its file say so, or its run was trained on simulated data. A source
        that cannot be read does not count: it cannot be presented.
        """
        if stimulus.name not in self._simulated:
            try:
                self._simulated[stimulus.name] = stimulus.is_simulated or self._reads_as_simulated(stimulus)
            except TactogramError:
                return False
        return self._simulated[stimulus.name]

    def limited(self) -> dict[str, list[str]]:
        """Return what of each stimulus was outside of what its runs learned, in sentences, by name.

        It is in the metadata of a file. Stimuli of which nothing is, or that cannot be read, are left out.
        """
        load = cache(self._loaded)
        for stimulus in self.study.made_stimuli:
            if stimulus.name not in self._limited:
                with suppress(TactogramError):
                    lines = [
                        line for facts in self._file_facts(stimulus) for line in facts.get("limited", ())
                    ]
                    for name in filter(None, (stimulus.run, stimulus.image_run)):
                        lines += self._limits(stimulus, load(name))
                    self._limited[stimulus.name] = lines
        return {name: lines for name, lines in self._limited.items() if lines}

    def display(self, stimulus: Stimulus | None) -> Display:
        """Return the display of a stimulus; the study's for silence."""
        name = (stimulus.display if stimulus else "") or self.study.display
        if name in shipped():
            return _display(name)
        path = self._path(name)
        if self._within:
            self._check_response(path)
        return _display(str(path))

    def check(self) -> None:
        """Refuse what cannot be presented, without making a stimulus: its level, display, files and names.

        Raises
        ------
        TactogramError
            The message names the stimulus, but of a level, which is mostly the study's.
        """
        for stimulus in self.study.made_stimuli:
            with _named(stimulus):
                if stimulus.is_played:
                    self._check_display(self.display(stimulus))
                if stimulus.simulated:
                    simulated_surface(stimulus.simulated)
                if stimulus.simulated_image:
                    image_family(stimulus.simulated_image)
                for name in filter(None, _files(stimulus)):
                    self._file(name)
            if stimulus.is_played:
                parse_level(stimulus.level or self.study.level)

    def check_places(self) -> None:
        """Refuse a study with a stimulus whose file, run or display is outside ``within``.

        Raises
        ------
        ParameterError, DataError
            The message names the stimulus.
        """
        for stimulus in self.study.all_stimuli:
            with _named(stimulus):
                for name in filter(None, _files(stimulus)):
                    self._path(name)
                for name in filter(None, (stimulus.run, stimulus.image_run)):
                    self._run(name)
                if stimulus.is_played:
                    self.display(stimulus)

    def _reads_as_simulated(self, stimulus: Stimulus) -> bool:
        if any(facts.get("simulated") for facts in self._file_facts(stimulus)):
            return True
        if not (runs := [name for name in (stimulus.run, stimulus.image_run) if name]):
            return False
        from tactogram.training import open_run  # loads torch

        return any(open_run(self._run(name)).kind().simulated for name in runs)

    def _file_facts(self, stimulus: Stimulus) -> list[Mapping[str, Any]]:
        files = ((stimulus.file, read_metadata), (stimulus.image, read_image_metadata))
        return [read(self._file(name)) for name, read in files if name]

    def _check_display(self, display: Display) -> None:
        if self.study.played_by == "stream":
            playback.check_streams(display)
        elif self.study.played_by == "browser":
            check_browser(display)

    def _rendered(self, stimulus: Stimulus, gain_db: float) -> SlotPlayback:
        signal, text = self.signal(stimulus), stimulus.level or self.study.level
        with _named(stimulus):
            level, signal = stronger(parse_level(text), signal, gain_db)
            drive = fit(
                signal,
                self.display(stimulus),
                level=level,
                axes=stimulus.axes or None,
                speed_mm_s=stimulus.speed_mm_s,
            )
        return SlotPlayback(drive, drive.signal.sha256, text, drive.report.display, gain_db)

    def _streamed(self, stimulus: Stimulus, gain_db: float) -> SlotPlayback:
        text, display = stimulus.level or self.study.level, self.display(stimulus)
        # A surface is fitted as a whole, at every gain; of a vibration the gain is a weight.
        fitted_db = gain_db if display_family(display.family).stream_surface is not None else 0.0
        key = (stimulus.name, fitted_db)
        if key not in self._streams:
            settings = texture_settings(display, stimulus.axes, seed=stimulus.seed)
            level, texture = parse_level(text), self._texture_of_run(stimulus, settings)
            if texture is None:
                level, signal = stronger(level, self.signal(stimulus), fitted_db)
            with _named(stimulus):
                if texture is None:
                    texture = texture_of_signal(stimulus.name, signal, settings, stimulus.speed_mm_s)
                self._streams[key] = stimulus_stream(texture, display, level, settings.most)
        stream = self._streams[key].stronger(gain_db - fitted_db)
        return SlotPlayback(None, stream.sha256, text, display.name, gain_db, stream)

    def _texture_of_run(
        self, stimulus: Stimulus, settings: playback.TextureSettings
    ) -> playback.StreamingTexture | None:
        """Return a texture over speed and force; None if there is only a signal to lay out."""
        if not stimulus.run:
            return None
        with _named(stimulus):
            run = self._loaded(stimulus.run)
            return playback.live_texture(run, stimulus.name, self._condition(stimulus, run), settings)

    def _make_signal(self, stimulus: Stimulus) -> Signal:
        if stimulus.run:
            content = self._generated(stimulus, stimulus.run)
            if not isinstance(content, Signal):
                raise ParameterError(f"{stimulus.run} generates images; give it as image_run")
            return content
        if stimulus.simulated:
            length = None if stimulus.autoregressive else stimulus.seconds
            signal = simulated_signal(
                stimulus.simulated, 0 if stimulus.autoregressive else stimulus.seed, length
            )
        elif stimulus.file:
            signal = read_signal(self._file(stimulus.file))
        else:
            raise ParameterError("it has no signal; give file, run or simulated")
        if stimulus.autoregressive:
            signal = autoregressive_signal(signal, stimulus)
        elif stimulus.file and stimulus.seconds is not None:
            signal = signal.cut(0, max(1, round(stimulus.seconds * signal.rate)))
        return reconstruction(signal, stimulus) if stimulus.reconstructed else signal

    def _generated(self, stimulus: Stimulus, run: str) -> Signal | Image:
        from tactogram.workflows import generate

        loaded = self._loaded(run)
        [content] = generate(
            loaded, self._condition(stimulus, loaded), seconds=stimulus.seconds, seed=stimulus.seed
        )
        return content

    def _condition(self, stimulus: Stimulus, run: LoadedRun) -> dict[str, Any]:
        condition: dict[str, Any] = {str(name): value for name, value in stimulus.given.items()}
        if stimulus.material:
            condition["material"] = {stimulus.material: 1.0}
        if stimulus.words:
            condition["words"] = dict(stimulus.words)
        if stimulus.photograph:
            condition["image"] = read_image(self._file(stimulus.photograph))
        if stimulus.vibration:
            condition["vibration"] = run.prepare_vibration(read_signal(self._file(stimulus.vibration)))
        return condition

    def _limits(self, stimulus: Stimulus, run: LoadedRun) -> list[str]:
        from tactogram.workflows import limits

        missing = run.missing_band(read_signal(self._file(stimulus.vibration))) if stimulus.vibration else []
        return [*map(str, limits(run, self._condition(stimulus, run))), *missing]

    def _loaded(self, name: str) -> LoadedRun:
        from tactogram.workflows import load_run  # loads torch

        return load_run(self._run(name))

    def _run(self, name: str) -> Path:
        own = self.folder / name
        return (None if own.exists() else shipped_run(name)) or self._path(name)

    def _path(self, name: str) -> Path:
        path = Path(name)
        path = path if path.is_absolute() else self.folder / path
        if self._within:
            path = path.resolve()
            if not any(path.is_relative_to(folder) for folder in self._within):
                raise ParameterError(
                    f"{name[:200]}: is outside the study's folder and the workspace; copy it there"
                )
        return path

    def _check_response(self, display: Path) -> None:
        """Refuse a display whose measured response is elsewhere; `open_display` finds other faults."""
        try:
            response = tomllib.loads(display.read_text(encoding="utf-8")).get("response")
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
            return
        if isinstance(response, dict) and isinstance(response.get("file"), str):
            self._path(str(display.parent / response["file"]))

    def _file(self, name: str) -> Path:
        path = self._path(name)
        if not path.is_file():
            raise DataError(path, "no such file")
        return path


def _files(stimulus: Stimulus) -> tuple[str | None, ...]:
    return stimulus.file, stimulus.image, stimulus.photograph, stimulus.vibration


def limited_lines(limited: Mapping[str, Sequence[str]]) -> list[str]:
    """Return `StudyStimuli.limited` as lines for people, the first `SHOWN` and how many more there are."""
    lines = [
        f"{stimulus_place(name)}: {sentence}" for name, sentences in limited.items() for sentence in sentences
    ]
    return lines[:SHOWN] + [f"{len(lines) - SHOWN} more such lines"] * (len(lines) > SHOWN)


@contextmanager
def _named(stimulus: Stimulus) -> Iterator[None]:
    """Name the stimulus in an error."""
    try:
        yield
    except TactogramError as error:
        raise type(error)(stimulus_place(stimulus.name), error) from error


def stimulus_place(name: str) -> str:
    """Return the place that an error of a stimulus names."""
    return f"stimulus {name}"


@lru_cache(maxsize=16)
def _display(name: str) -> Display:
    return open_display(name)


def stronger(level: Level, signal: Signal, gain_db: float) -> tuple[Level, Signal]:
    """Return level and signal that are played ``gain_db`` above ``level``.

    If the level follows the signal, the signal is scaled; if it replaces the signal's own (``peak``,
    ``sensation=DB``), the level is.
    """
    if gain_db == 0:
        return level, signal
    factor = 10 ** (gain_db / 20)
    if level.kind == "peak" and level.value is not None:
        return replace(level, value=level.value * factor), signal
    if level.kind == "sensation" and level.value is not None:
        return replace(level, value=level.value + gain_db), signal
    return level, signal.with_samples(signal.samples * np.float32(factor))


BROWSER_RATES = (8000, 96_000)
"""Rates that every browser plays, Hz (Web Audio API, createBuffer); beyond them Firefox refuses."""


def check_browser(display: Display) -> None:
    """Raise `ParameterError` for a drive that is not in parts of full scale, or whose rate browsers do not play."""
    if not plays_in_browser(display):
        low, high = BROWSER_RATES
        usable = ", ".join(known for known in shipped() if plays_in_browser(open_display(known)))
        raise ParameterError(
            f"a browser plays parts of full scale at {low} to {high} Hz, {display.name} takes {display.unit} at "
            f"{display.rate:g} Hz: give a display such as {usable}, or played_by = 'server'"
        )


def plays_in_browser(display: Display) -> bool:
    """Return whether `check_browser` accepts a display."""
    low, high = BROWSER_RATES
    return display.unit == "1" and low <= display.rate <= high and display.rate % 1 == 0
