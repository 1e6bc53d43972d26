"""FrictGAN's pairs: windows of photographs of fabrics, and spectrograms of the friction measured along them.

S. Cai, Y. Ban, T. Narumi, K. Zhu, "FrictGAN: Frictional Signal Generation from Fabric Texture Images using Generative
Adversarial Network", ICAT-EGVE 2020; made of HapTex, whose fabrics the numbers are. Layout, as the authors' code opens
it: ``{train,valid,test}/FABRIC/image/K.jpg`` (1024 x 1024 pixels) and ``…/FABRIC/output_data/K.txt``, the 257 x 11
amplitudes of a Hamming window of 512 every 128 samples (librosa's scale, ends mirrored) of 1280 samples of a friction
coefficient. Checked on one real spectrogram, which is in their repository; no photograph was at hand.

Notes on the data
- **Amplitudes have no phase.** A friction that has about them is recovered (`recovered`), and ``history`` says with
  which error.
- Windows K and K + 1 of a fabric overlap almost entirely, and the published parts interleave: each fabric is a
  ``session``, so that ``--by session`` holds out whole fabrics. The published part is the label ``part``.
- Millimetres are not stated: 1280 samples for 1024 pixels of 2362 that are taken to be 100 mm, as in `haptex`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import hamming

from tactogram.datasets import ImportItem, Recording, files_below, number_columns
from tactogram.errors import DataError
from tactogram.signal import Signal

TITLE = "FrictGAN: windows of fabrics' photographs and spectrograms of their friction"
LICENCE = "not stated"
DESCRIPTION = (
    "{train,valid,test}/FABRIC/image/K.jpg and output_data/K.txt (257 x 11 amplitudes): friction over displacement, "
    "recovered from amplitudes without phase. One real spectrogram was checked."
)

UNVERIFIED = (
    "the photographs' millimetres are assumed, and the phase of the friction is recovered, not measured"
)

BINS, FRAMES, WINDOW, HOP = 257, 11, 512, 128
PER_PIXEL = 1.25
MM_PER_PIXEL = 100 / 2362
PIXELS = 1024
ITERATIONS = 64


def find(folder: Path) -> list[ImportItem]:
    """Return an item per spectrogram, with its window of the photograph."""
    items = []
    for name, path in files_below(folder, (".txt",)).items():
        if path.parent.name == "output_data":
            image = path.parents[1] / "image" / f"{path.stem}.jpg"
            info = {"fabric": path.parents[1].name, "part": path.parents[2].name, "recording": path.stem}
            shown = image if image.is_file() else None
            items.append(ImportItem(name, (path,), info, shown, PIXELS * MM_PER_PIXEL if shown else None))
    if not items:
        raise DataError(folder, "must hold {train,test}/FABRIC/output_data/K.txt, found none")
    return items


def read(item: ImportItem) -> list[Recording]:
    """Return the friction along one window."""
    [path] = item.paths
    amplitudes = number_columns(path, separator=r"\s+").T
    if amplitudes.shape != (BINS, FRAMES) or (amplitudes < 0).any():
        raise DataError(
            path,
            f"must hold {BINS} x {FRAMES} amplitudes of at least 0, got {amplitudes.shape[0]} x "
            f"{amplitudes.shape[1]}, the smallest {amplitudes.min():g}",
        )
    friction, error = recovered(amplitudes)
    fabric = item.info["fabric"]
    return [
        Recording(
            streams={"friction": Signal(friction, PER_PIXEL / MM_PER_PIXEL, "1", ("along",), "displacement")},
            material=f"fabric{fabric.zfill(3)}",
            contactor="finger",
            session=f"fabric{fabric.zfill(3)}",
            labels={name: item.info[name] for name in ("part", "recording")},
            source=item.name,
            history=(
                f"recovered from amplitudes, which have no phase; its own are {100 * error:.2g} % off",
                "1280 samples for 1024 pixels of 100 mm / 2362: assumed",
            ),
        )
    ]


def recovered(amplitudes: NDArray[np.float64]) -> tuple[NDArray[np.float32], float]:
    """Return a friction coefficient that has about these amplitudes, shape (bin, frame), and their relative error.

    D. W. Griffin & J. S. Lim, "Signal estimation from modified short-time Fourier transform", IEEE Transactions on
    Acoustics, Speech, and Signal Processing 32(2), 1984; from the level in bin 0, whose phase stays 0.
    """
    window = hamming(WINDOW, sym=False)
    size, edge = (FRAMES - 1) * HOP + WINDOW, WINDOW // 2
    places = HOP * np.arange(FRAMES)[:, None] + np.arange(WINDOW)
    weight = np.bincount(places.ravel(), np.tile(window**2, FRAMES), size)

    def spectrum(x: NDArray[np.float64]) -> NDArray[np.complex128]:
        return np.fft.rfft(window * np.pad(x, edge, mode="reflect")[places]).T

    level = np.interp(np.arange(size - WINDOW), HOP * np.arange(FRAMES), amplitudes[0] / window.sum())
    x = level + 1e-3 * level.mean() * np.random.default_rng(0).standard_normal(len(level))
    for _ in range(ITERATIONS):
        phase = np.exp(1j * np.angle(spectrum(x)))
        phase[0] = 1
        frames = window * np.fft.irfft((amplitudes * phase).T)
        x = (np.bincount(places.ravel(), frames.ravel(), size) / weight)[edge:-edge]
    x = np.maximum(x, 0)
    error = np.linalg.norm(np.abs(spectrum(x)) - amplitudes) / np.linalg.norm(amplitudes)
    return x.astype(np.float32), float(error)
