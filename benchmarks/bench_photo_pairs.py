"""The loader of photo-and-spectrogram pairs at the published size, beside the plainest PyTorch form of the same.

Photographs of 320 x 480 pixels (PNG) and recordings of 4.8 s at 10 kHz, both simulated (noise), three materials; pairs
are 256 x 256 grey and 256 x 256 log magnitudes, batches of 32. The plain form is a `Dataset` that opens, crops, flips,
jitters and greys with Pillow and torchvision's transforms, takes `torch.stft` of the whole recording, crops and resizes
it, in a `DataLoader`; it holds nothing between items. Ours is measured while everything is made for the first time,
once finished crops are kept, and with nothing kept. `over a step`: pairs that are fed per pair that the published
generator's forward and backward pass alone eats (a whole step eats fewer). Memory is that of a process of its own
after three epochs' worth of random batches, less what it was before, with 64 MiB of crops allowed.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import torch
from PIL import Image as Pillow

from tactogram.datasets import Examples, Recording, Segment, create_store, open_store, whole_photographs
from tactogram.features.photo_crops import PhotoCrops
from tactogram.features.photo_pairs import WeakPairs, shuffled, weak_pairs
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.nn.unet import UNet
from tactogram.nn.vision_import import vision_module
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal

MATERIALS = ("a", "b", "c")
RATE = 10_000.0
BATCH = 32
PICTURE = SpectrogramPicture(rate=RATE, floor_db=-80.0, ceiling_db=20.0)
SIZES = (10, 40, 160)
"""Photographs, and recordings, of each material in the stores whose memory is measured."""


def run() -> list[dict[str, Any]]:
    """Return a row per loader, and a row per size of store."""
    with tempfile.TemporaryDirectory(prefix="bench-pairs-") as name:
        store = Path(name) / "store"
        photos, recordings = write(store, 10, plain=Path(name))
        eaten = step_pairs_per_second()
        plain = [
            (f"plain DataLoader, {workers} workers", plain_rate(photos, recordings, workers))
            for workers in (0, 2)
        ]
        slowest = plain[0][1]
        first = loader(store)
        ours = [
            ("ours, made for the first time", rate(first, 20)),
            ("ours, kept", rate(kept(first), 40)),
            ("ours, nothing kept", rate(loader(store, cache_mib=0.0), 20)),
        ]
        rows = [
            {"what": what, "pairs/s": fed, "over plain": fed / slowest, "over a step": fed / eaten}
            for what, fed in (*plain, *ours)
        ]
        rows.append({"what": "the generator's forward and backward pass", "pairs/s": eaten})
        for size in SIZES:
            write(Path(name) / f"store{size}", size)
            held = subprocess.run(
                [sys.executable, "-m", "benchmarks.bench_photo_pairs", str(Path(name) / f"store{size}")],
                capture_output=True,
                text=True,
                check=True,
            )
            rows.append({"what": "memory"} | json.loads(held.stdout))
        return rows


def write(store: Path, count: int, *, plain: Path | None = None) -> tuple[list[Path], list[Path]]:
    """Write a store of ``count`` photographs and recordings per material; and the same as plain files."""
    random = np.random.default_rng(0)
    photographs, recordings = [], []
    for material in MATERIALS:
        for _ in range(count):
            coarse = random.integers(0, 256, (80, 120, 3), np.uint8)
            pixels = np.asarray(Pillow.fromarray(coarse).resize((480, 320)))
            photographs.append((material, Image(pixels)))
            samples = random.standard_normal((1, 48_000))
            recordings.append(
                Recording(
                    streams={"acceleration": Signal(samples, RATE, "m/s^2")},
                    material=material,
                    simulated=True,
                )
            )
    create_store(store, recordings, name="noise", licence="CC0-1.0", photographs=photographs)
    files: tuple[list[Path], list[Path]] = ([], [])
    if plain is not None:
        for number, ((_, image), recording) in enumerate(zip(photographs, recordings, strict=True)):
            files[0].append(plain / f"{number}.png")
            Pillow.fromarray(image.pixels).save(files[0][-1])
            files[1].append(plain / f"{number}.npy")
            np.save(files[1][-1], recording.streams["acceleration"].samples[0])
    return files


def loader(path: Path, *, cache_mib: float = 384.0) -> WeakPairs:
    """Return the pairs of all that is in a store."""
    store = open_store(path)
    examples = Examples(
        store, [Segment(info.id) for info in store.index], Preparation(), photographs=whole_photographs(store)
    )
    return weak_pairs(examples, PICTURE, PhotoCrops(), seed=0, cache_mib=cache_mib)


def kept(pairs: WeakPairs) -> WeakPairs:
    """Make every crop once."""
    for column, make in ((0, pairs.photo_crop), (1, pairs.picture_crop)):
        for crop in np.unique(pairs.pairs[:, column]):
            make(int(crop))
    return pairs


def rate(pairs: WeakPairs, count: int) -> float:
    """Return pairs per second of ``count`` batches."""
    begun = time.perf_counter()
    for number in range(count):
        pairs.batch(shuffled(len(pairs), BATCH, number, seed=0))
    return count * BATCH / (time.perf_counter() - begun)


class Plain(torch.utils.data.Dataset[tuple[torch.Tensor, torch.Tensor]]):
    """What one writes first."""

    def __init__(self, photos: list[Path], recordings: list[Path]) -> None:
        self.photos, self.recordings = photos, recordings
        transforms = vision_module("torchvision.transforms")
        self.transform = transforms.Compose(
            [
                transforms.RandomCrop(256),
                transforms.RandomHorizontalFlip(),
                transforms.RandomVerticalFlip(),
                transforms.ColorJitter(0.2, 0.2),
                transforms.Grayscale(),
                transforms.ToTensor(),
                transforms.Normalize(0.5, 0.5),
            ]
        )
        self.window = torch.hamming_window(512)

    def __len__(self) -> int:
        return 100 * len(self.photos)

    def __getitem__(self, item: int) -> tuple[torch.Tensor, torch.Tensor]:
        place = item % len(self.photos)
        photo = self.transform(Pillow.open(self.photos[place]).convert("RGB"))
        samples = torch.from_numpy(np.load(self.recordings[place]))
        magnitude = torch.stft(samples, 512, 128, window=self.window, return_complex=True).abs()
        first = int(torch.randint(magnitude.shape[1] - 255, ()))
        crop = magnitude[:, first : first + 256][None, None]
        crop = torch.nn.functional.interpolate(crop, (256, 256), mode="bilinear", antialias=True)[0]
        db = 20 * torch.log10(crop.clamp_min(1e-4))
        return photo, ((db + 80) / 50 - 1).clamp(-1, 1)


def plain_rate(photos: list[Path], recordings: list[Path], workers: int) -> float:
    """Return pairs per second of a DataLoader, its workers started."""
    batches = iter(
        torch.utils.data.DataLoader(
            Plain(photos, recordings), batch_size=BATCH, shuffle=True, num_workers=workers
        )
    )
    for _ in range(3):
        next(batches)
    begun = time.perf_counter()
    for _ in range(12):
        next(batches)
    return 12 * BATCH / (time.perf_counter() - begun)


def step_pairs_per_second() -> float:
    """Return how many pairs a second the published generator's forward and backward pass eats, in batches of 4."""
    network = UNet(into=1, out=1, widths=(64, 128, 256, 512, 512, 512, 512, 512))  # Table 1
    photo = torch.zeros(4, 1, 256, 256)
    seconds = []
    for _ in range(3):
        begun = time.perf_counter()
        network(photo).sum().backward()
        seconds.append(time.perf_counter() - begun)
    return 4 / min(seconds)


def memory(path: Path) -> dict[str, Any]:
    """Return what pairs of a store take, MiB."""
    process = psutil.Process()
    torch.fft.rfft(torch.zeros(512))
    before = process.memory_info().rss
    pairs = loader(path, cache_mib=64.0)
    most = 0
    for number in range(60):
        pairs.batch(shuffled(len(pairs), BATCH, number, seed=0))
        most = max(most, process.memory_info().rss)
    return {
        "photographs": len(pairs.photo_sources),
        "recordings": len(pairs.recording_sources),
        "pairs": len(pairs),
        "memory (MiB)": round((most - before) / 2**20),
    }


if __name__ == "__main__":
    print(json.dumps(memory(Path(sys.argv[1]))))
