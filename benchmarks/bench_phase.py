"""Phase recovery: how near, in how much time, beside `librosa.griffinlim` in the same run.

Quality is spectral convergence: 20 log10( || |STFT(x)| - A || / ||A|| ) of the signal x that came out, with the
STFT that the magnitude A is of (`tactogram.features.spectral_convergence`, for librosa's signals too). Time is given
as a ratio to librosa's 32 iterations on the same recording: each repetition runs librosa and every method in turn,
so what else the machine does weighs on all of them. One thread each: torch is set to one, and librosa's transforms
(numpy, scipy) have no more. float32. Compilation and planning happen in a call before that is not timed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import librosa
import numpy as np
import soundfile
import torch
from numpy.typing import NDArray

from tactogram.features import STFT, recover, spectral_convergence
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass
from tactogram.signal.resampling import resample

TRANSFORMS = (STFT(256, 64, "hann"), STFT(512, 128, "hamming"), STFT(256, 128, "hamming"))
METHODS = (
    ("random", "griffin_lim", 32),
    ("random", "fast_griffin_lim", 32),
    ("random", "admm", 32),
    ("gradient", "griffin_lim", 0),
    ("gradient", "fast_griffin_lim", 32),
    ("gradient", "admm", 32),
    ("gradient", "admm+fast_griffin_lim", 8),
    ("gradient", "admm+fast_griffin_lim", 16),
    ("gradient", "admm+fast_griffin_lim", 24),
    ("gradient", "admm+fast_griffin_lim", 32),
    ("gradient", "admm+fast_griffin_lim", 64),
    ("gradient", "admm+fast_griffin_lim", 100),
)
REPETITIONS = 3


def run() -> list[dict[str, Any]]:
    """Return a row per data set, transform and method; see the module for what is measured."""
    rows = []
    for data, recordings in datasets().items():
        for transform in TRANSFORMS:
            with one_thread():
                seconds, quality = measure(transform, recordings)
            baseline = next(iter(seconds))
            for name in seconds:
                # The median over repetitions of one recording's ratio, then the mean over recordings.
                ratio = np.median(seconds[name] / seconds[baseline], axis=1)
                rows.append(
                    {
                        "data": data,
                        "recordings": len(recordings),
                        "stft": f"{transform.window} {transform.n_fft} hop {transform.hop}",
                        "method": name[0],
                        "iterations": name[1],
                        "seconds_ratio_to_librosa": round(float(ratio.mean()), 3),
                        "seconds_ratio_sd": round(float(ratio.std()), 3),
                        "spectral_convergence_db": round(float(quality[name].mean()), 2),
                        "spectral_convergence_sd": round(float(quality[name].std()), 2),
                        "better_than_librosa_db": round(float((quality[baseline] - quality[name]).mean()), 2),
                        "threads": "torch 1, librosa 1",
                    }
                )
    return rows


def measure(
    transform: STFT, recordings: list[NDArray[np.float32]]
) -> tuple[dict[tuple[str, int], NDArray[np.float64]], dict[tuple[str, int], NDArray[np.float64]]]:
    """Return seconds (recording, repetition) and spectral convergence in dB (recording,) by method."""
    seconds: dict[tuple[str, int], list[list[float]]] = {}
    quality: dict[tuple[str, int], list[float]] = {}
    for samples in recordings:
        whole = len(samples) - len(samples) % transform.hop  # librosa takes whole hops only
        magnitude = transform.forward(torch.from_numpy(samples[:whole])).abs()
        jobs = methods(magnitude, transform, whole)
        for name, job in jobs.items():
            x = torch.as_tensor(job())
            quality.setdefault(name, []).append(float(spectral_convergence(x, magnitude, transform)))
        times: dict[tuple[str, int], list[float]] = {name: [] for name in jobs}
        for _ in range(REPETITIONS):
            for name, job in jobs.items():
                start = time.perf_counter()
                job()
                times[name].append(time.perf_counter() - start)
        for name, taken in times.items():
            seconds.setdefault(name, []).append(taken)
    return (
        {name: np.array(values) for name, values in seconds.items()},
        {name: np.array(values) for name, values in quality.items()},
    )


def methods(
    magnitude: torch.Tensor, transform: STFT, length: int
) -> dict[tuple[str, int], Callable[[], Any]]:
    """Return what is timed, by name and iterations; the first is what the others are compared with."""
    array = magnitude.numpy()

    def theirs(iterations: int) -> NDArray[np.float32]:
        return librosa.griffinlim(
            array,
            n_iter=iterations,
            hop_length=transform.hop,
            n_fft=transform.n_fft,
            window=transform.window,
            momentum=0.99,
            random_state=0,
            length=length,
        )

    def ours(start: Any, iteration: Any, iterations: int) -> Callable[[], torch.Tensor]:
        return lambda: recover(
            magnitude, transform, length, start=start, iteration=iteration, iterations=iterations
        )

    jobs: dict[tuple[str, int], Callable[[], Any]] = {
        ("librosa.griffinlim (momentum 0.99)", n): partial(theirs, n) for n in (32, 128)
    }
    for start, iteration, iterations in METHODS:
        name = f"{start} start" if iterations == 0 else f"{start} start, {iteration}"
        jobs[name, iterations] = ours(start, iteration, iterations)
    return jobs


def datasets() -> dict[str, list[NDArray[np.float32]]]:
    """Return recordings by name: the real ones where they are, else simulated noise."""
    root = Path(os.environ.get("TACTOGRAM_REAL_DATA") or Path(__file__).parents[2] / "shared" / "data")
    found = {}
    if (root / "lmt108_sound").is_dir():
        found["lmt108_sound, real, 20-1000 Hz, 2.5 kHz"] = lmt108(root / "lmt108_sound")
    if (root / "biotac_slide").is_dir():
        found["biotac_slide PAC, real, as recorded, 2.2 kHz"] = biotac(root / "biotac_slide")
    return found or {"simulated noise textures, 2.5 kHz": simulated()}


def lmt108(folder: Path) -> list[NDArray[np.float32]]:
    """Return the sound of stroking 20 materials, one recording each."""
    recordings = []
    for path in sorted(folder.rglob("*.flac"))[::8]:
        samples, rate = soundfile.read(path, dtype="float32")
        signal = resample(bandpass(Signal(samples, rate, "1"), 20, 1000), 2500)
        recordings.append(np.array(signal.samples[0]))
    return recordings


def biotac(folder: Path) -> list[NDArray[np.float32]]:
    """Return the vibration channel of the first slide over each of 15 materials; it is rectified."""
    recordings = []
    for path in sorted(folder.glob("mat*.npz")):
        with np.load(path, allow_pickle=False) as archive:
            rows = archive["pac"][: int(archive["lengths"][0])]
        recordings.append(rows.reshape(-1).astype(np.float32))
    return recordings


def simulated(count: int = 12, rate: int = 2500, seconds: float = 4.8) -> list[NDArray[np.float32]]:
    """Return seeded noise of random bands whose level goes up and down as in strokes."""
    recordings = []
    for seed in range(count):
        random = np.random.default_rng(seed)
        low = random.uniform(20, 200)
        noise = Signal(random.standard_normal(int(seconds * rate)).astype(np.float32), rate, "1")
        texture = bandpass(noise, low, low * random.uniform(2, 5)).samples[0]
        stroke = 0.1 + np.abs(np.sin(np.pi * random.uniform(0.5, 2) * np.arange(len(texture)) / rate))
        recordings.append((texture * stroke).astype(np.float32))
    return recordings


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread for a while."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)
