"""What tactogram takes for a job, as a ratio to what one would take without it; below 1 is faster.

Each repetition runs both in turn in one process: ratios of processor time, median and sd of the repetitions, after a
call of each that is not timed; one thread each. "quality of both", tactogram's first: spectral convergence in dB (lower
is nearer), share of recordings classified correctly, most memory in MB. All data is simulated or noise. A library that
is not installed has no row; three come with
`pip install --no-deps aeon deprecated wrapt webdataset braceexpand polars polars-runtime-32`.

- import: CSVs as a logger writes them, 2 to 10 s of three axes at 1 kHz, into a store, beside reading each and writing
  one Parquet file. "jittered": stamps up to 0.2 ms late; tactogram solves for the band-limited signal, `numpy.interp`
  draws straight lines. "one long CSV" is read alone: 0.9 million rows of full precision.
- window: 1 s of one of 200 recordings of 2 to 10 s, at random; tar shards are read in order.
- classifier: 8 materials, 6 recordings of 4 s each to learn from and 4 to classify, windows of 1 s, half overlapping.
- training step: the same network and batch in a loop of plain PyTorch.
- stream: blocks of 5 ms, 10 textures of order 60 under a moving finger, beside a callback as one would give it to
  `sounddevice`, which takes the nearest of 15 filters.
"""

from __future__ import annotations

import copy
import io
import itertools
import platform
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import librosa
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv
import pyarrow.dataset
import pyarrow.parquet as pq
import torch
from scipy.signal import ShortTimeFFT, get_window, lfilter, resample_poly, welch
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.linear_model import RidgeClassifierCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits
from torch.nn import functional as F

from benchmarks import bench_phase, bench_streaming
from benchmarks.timing import beside
from tactogram import read_signal
from tactogram.datasets import Recording, create_store, open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.store.layout import axis_column
from tactogram.features import STFT, recover, spectral_convergence
from tactogram.model import Example, SignalKind
from tactogram.models import find
from tactogram.recipe import Recipe
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

RATE = 1000
REPETITIONS = 5
Job = Callable[[], Any]
Pair = tuple[str, str, str, Job, Job, str]
"""Job, what of ours, what of theirs (distribution first), theirs, ours, and the quality of both."""


def run() -> list[dict[str, Any]]:
    """Return a row per job and library; see the module for what is measured."""
    rows = []
    groups = (recovery, spectra, resampling, classifiers, training, stream, windows, imports)
    with (
        tempfile.TemporaryDirectory(prefix="bench-comparison-") as folder,
        threadpool_limits(1),
        bench_phase.one_thread(),
    ):
        for pair in itertools.chain.from_iterable(group(Path(folder)) for group in groups):
            job, ours, theirs, their_job, our_job, quality = pair
            package = theirs.split(" ")[0]
            sys.stderr.write(f"  {job}, {theirs} …\n")
            known = version(package) if package != "tarfile" else platform.python_version()
            row = {"job": job, "tactogram": ours, "beside": theirs, "version": known}
            rows.append(row | beside(their_job, our_job, REPETITIONS) | {"quality of both": quality})
    return rows


def recovery(_: Path) -> Iterator[Pair]:
    transform = STFT(256, 64, "hann")
    samples = bench_phase.simulated(1)[0]
    samples = samples[: len(samples) // 64 * 64]
    magnitude = transform.forward(torch.from_numpy(samples)).abs()

    def theirs() -> Any:
        return librosa.griffinlim(
            magnitude.numpy(), n_iter=32, hop_length=64, n_fft=256, random_state=0, length=len(samples)
        )

    def ours() -> Any:
        return recover(magnitude, transform, len(samples), iterations=16)

    off = [float(spectral_convergence(torch.as_tensor(f()), magnitude, transform)) for f in (ours, theirs)]
    quality = f"{off[0]:.1f} and {off[1]:.1f} dB"
    yield "phase recovery", "recover, 16 iterations", "librosa griffinlim, 32", theirs, ours, quality


def spectra(_: Path) -> Iterator[Pair]:
    x = np.random.default_rng(0).standard_normal((48, 4096)).astype(np.float32)
    transform, tensor = STFT(256, 64, "hann"), torch.from_numpy(x)

    def ours() -> Any:
        return transform.forward(tensor)

    short = ShortTimeFFT(get_window("hann", 256), 64, RATE)
    yield "spectrogram", "STFT", "librosa stft", lambda: librosa.stft(x, n_fft=256, hop_length=64), ours, ""
    yield "spectrogram", "STFT", "scipy ShortTimeFFT", lambda: short.stft(x), ours, ""


def resampling(_: Path) -> Iterator[Pair]:
    signal = Signal(np.random.default_rng(0).standard_normal((1, 60 * RATE)), RATE, "1")

    def theirs() -> Any:
        return resample_poly(signal.samples, 48, 1, axis=1)

    yield "1 to 48 kHz, 60 s", "resample", "scipy resample_poly", theirs, lambda: resample(signal, 48_000), ""


def classifiers(_: Path) -> Iterator[Pair]:
    materials = tuple("abcdefgh")
    kind = SignalKind(float(RATE), "m/s^2", ("x", "y", "z"), materials, True, "time")
    rng = np.random.default_rng(0)

    def texture(place: int) -> Signal:
        x = rng.standard_normal((3, 4 * RATE))
        angle = 2 * np.pi * (140 + 8 * place + rng.normal(0, 3)) / RATE
        return Signal(lfilter([1], [1, -1.8 * np.cos(angle), 0.81], x), RATE, "m/s^2")

    data = [Example(f"{m}{i}", texture(p), m) for p, m in enumerate(materials) for i in range(10)]
    learned, unseen = [d for d in data if d.id[1] < "6"], [d for d in data if d.id[1] >= "6"]

    def ours() -> float:
        facts = find("stroke_statistics")
        learner = facts.build(facts.config({}), kind, seed=0)
        for stage in learner.stages(learned):
            learner.step(stage, next(learner.batches(stage, learned, seed=0)))
        return float(learner.validate(unseen)["recording_accuracy"])

    def cut(examples: list[Example]) -> Any:
        starts = range(0, 4 * RATE - RATE + 1, RATE // 2)
        x = np.stack([e.signal.samples[:, s : s + RATE] for e in examples for s in starts])
        return x, np.repeat([e.material for e in examples], len(starts))

    def theirs(classifier: Callable[[], Any], features: Callable[[Any], Any]) -> float:
        model = classifier()
        model.fit(features(cut(learned)[0]), cut(learned)[1])
        said = model.predict(features(cut(unseen)[0])).reshape(len(unseen), -1)
        named = [max({*row}, key=[*row].count) for row in said]
        return float(np.mean([name == e.material for name, e in zip(named, unseen, strict=True)]))

    def bands(x: Any) -> Any:
        return np.log(welch(x, RATE, nperseg=128)[1] + 1e-12).reshape(len(x), -1)

    def discriminant() -> float:
        plain = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto")
        return theirs(lambda: make_pipeline(StandardScaler(), plain), bands)

    name = "learn and classify"
    share, theirs_share = ours(), discriminant()
    pipeline = "scikit-learn bands, shrunk LDA"
    yield name, "stroke_statistics", pipeline, discriminant, ours, f"{share:.2f} and {theirs_share:.2f}"
    if find_spec("aeon"):
        from aeon.transformations.collection.convolution_based import MiniRocket

        def rocket() -> float:
            return theirs(lambda: make_pipeline(MiniRocket(random_state=0), RidgeClassifierCV()), lambda x: x)

        quality = f"{share:.2f} and {rocket():.2f}"
        yield name, "stroke_statistics", "aeon MiniRocket and ridge", rocket, ours, quality


def training(_: Path) -> Iterator[Pair]:
    facts = find("stroke_cnn")
    kind = SignalKind(330.0, "1", ("x", "y", "z"), tuple("abcdefghi"), True, "time")
    rng = np.random.default_rng(0)
    data = [
        Example(str(n), Signal(rng.standard_normal((3, 9000)), 330.0, "1"), "abcdefghi"[n % 9])
        for n in range(18)
    ]
    learner = facts.build(facts.config(Recipe.load(facts.recipe("quick")).config), kind, seed=0)
    first, *_, stage = learner.stages(data)
    learner.step(first, data)
    x, material = batch = next(learner.batches(stage, data, seed=0))
    network = copy.deepcopy(learner.network)
    adam, target = torch.optim.Adam(network.parameters()), torch.as_tensor(material)

    def theirs() -> None:
        loss = F.cross_entropy(network((torch.from_numpy(x) - learner.mean) / learner.scale), target)
        adam.zero_grad()
        loss.backward()
        adam.step()
        loss.item()

    plain = "torch a loop of one's own"
    yield "training step, stroke_cnn", "Learner.step", plain, theirs, lambda: learner.step(stage, batch), ""


def stream(_: Path) -> Iterator[Pair]:
    count, blocks = 10, 200
    engine = bench_streaming.engine(bench_streaming.made_up(8000.0), count, SimulatedHand(60, seed=0))
    engine.warm_up()
    clock = itertools.count()
    rng = np.random.default_rng(0)
    poles = 0.9 * np.exp(1j * rng.uniform(0, np.pi, (15, 30)))
    filters = [np.poly(np.concatenate([each, each.conj()])).real for each in poles]
    speeds, forces = np.meshgrid((25, 50, 100, 200, 400), (0.2, 0.6, 1.2))
    states = np.zeros((count, 60))

    def ours() -> None:
        for _ in range(blocks):
            engine.render(next(clock) * 0.005)

    def theirs() -> None:
        for n in range(blocks):
            speed, force = 100 + 80 * np.sin(0.05 * n), 0.6 + 0.3 * np.sin(0.03 * n)
            distance = (np.log(speeds / speed)) ** 2 + (forces - force) ** 2
            chosen, out = filters[int(distance.argmin())], np.zeros(40)
            for i in range(count):
                made, states[i] = lfilter([1.0], chosen, rng.standard_normal(40), zi=states[i])
                out += made

    yield "stream, 200 blocks", "Engine.render", "scipy lfilter in a callback", theirs, ours, ""


def windows(folder: Path) -> Iterator[Pair]:
    rng = np.random.default_rng(0)
    lengths = rng.integers(2 * RATE, 10 * RATE, 200)
    signals = [Signal(rng.standard_normal((3, n), np.float32), RATE, "m/s^2") for n in lengths]
    recordings = [Recording(streams={"a": s}, material="m", simulated=True) for s in signals]
    store = create_store(folder / "windows", recordings, name="noise", licence="CC0-1.0", simulated=True)
    ids, files = [r.id for r in recordings], [str(folder / "windows" / s.file) for s in store.facts.shards]
    table = pyarrow.dataset.dataset(files)
    with tarfile.open(folder / "noise.tar", "w") as tar:
        for number, signal in enumerate(signals):
            buffer = io.BytesIO()
            np.save(buffer, signal.samples)
            entry = tarfile.TarInfo(f"{number}.npy")
            entry.size = buffer.tell()
            tar.addfile(entry, io.BytesIO(buffer.getvalue()))

    def drawn(count: int) -> Iterator[tuple[int, int]]:
        for i in rng.integers(len(ids), size=count):
            yield int(i), int(rng.integers(lengths[i] - RATE))

    opened = open_store(folder / "windows")
    names = [axis_column("a", axis) for axis in "xyz"]

    def ours(count: int) -> Job:
        return lambda: [
            opened.signal(ids[i], "a", start=at, stop=at + RATE).samples for i, at in drawn(count)
        ]

    def taken() -> Any:
        for i, at in drawn(20):
            rows = table.take([i], columns=names)
            np.stack([rows[name][0].values.to_numpy()[at : at + RATE] for name in names])

    def in_order() -> Any:
        with tarfile.open(folder / "noise.tar") as tar:
            for entry in tar:
                x = np.load(io.BytesIO(tar.extractfile(entry).read()))  # type: ignore[union-attr]
                at = int(rng.integers(x.shape[1] - RATE))
                x[:, at : at + RATE].copy()

    yield "window at random", "Store.signal", "pyarrow dataset.take", taken, ours(20), ""
    yield "window at random", "Store.signal", "tarfile shards in order", in_order, ours(len(ids)), ""
    if find_spec("webdataset"):
        import webdataset

        def decoded() -> None:
            shards = webdataset.WebDataset(str(folder / "noise.tar"), shardshuffle=False).shuffle(100)
            for sample in shards.decode():
                at = int(rng.integers(sample["npy"].shape[1] - RATE))
                sample["npy"][:, at : at + RATE].copy()

        yield "window at random", "Store.signal", "webdataset shuffled", decoded, ours(len(ids)), ""


def imports(folder: Path) -> Iterator[Pair]:
    numbers = itertools.count()
    for name, late, count in (("import, 60 CSVs", 0.0, 60), ("import, 10 jittered CSVs", 0.2e-3, 10)):
        source = folder / f"logger{late:g}"
        write_logs(source, count, late)
        files = sorted(source.rglob("*.csv"))

        def ours(source: Path = source) -> None:
            import_dataset("folder", source, folder / f"store{next(numbers)}", workers=1)

        def theirs(files: list[Path] = files, even: bool = not late) -> None:
            frames = [pd.read_csv(file).assign(material=file.parent.name) for file in files]
            pd.concat(frames if even else map(interpolated, frames)).to_parquet(folder / "all.parquet")

        def arrow(files: list[Path] = files) -> None:
            pq.write_table(pa.concat_tables(map(pyarrow.csv.read_csv, files)), folder / "all.parquet")

        what = "pandas read_csv, to_parquet" if not late else "pandas the same, numpy.interp"
        yield name, "import_dataset", what, theirs, ours, ""
        if late:
            continue
        yield name, "import_dataset", "pyarrow csv, parquet", arrow, ours, ""
        if find_spec("polars"):
            import polars

            def frames(files: list[Path] = files) -> None:
                polars.concat(map(polars.read_csv, files)).write_parquet(folder / "all.parquet")

            yield name, "import_dataset", "polars read_csv, write_parquet", frames, ours, ""
    path = folder / "long.csv"
    write_log(path, 900_000, np.random.default_rng(0), 0.0, digits=17)
    most = [peak_mb(code, path) for code in ("from tactogram import read_signal as f", PANDAS)]
    quality = f"{most[0]} and {most[1]} MB"
    one = "one long CSV"
    yield one, "read_signal", "pandas read_csv", lambda: pd.read_csv(path), lambda: read_signal(path), quality


PANDAS = "from pandas import read_csv as f"


def interpolated(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the samples at even times, joined by straight lines."""
    times = frame.iloc[:, 0].to_numpy()
    even = np.arange(times[0], times[-1], 1 / RATE)
    return pd.DataFrame({name: np.interp(even, times, frame[name]) for name in frame.columns[1:4]})


def peak_mb(code: str, path: Path) -> int:
    """Return the most memory of a process that reads a file."""
    lines = (
        f"{code}\nx = f({str(path)!r})\nprint(open('/proc/self/status').read().split('VmHWM:')[1].split()[0])"
    )
    printed = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, check=True).stdout
    return int(printed) // 1024


def write_logs(folder: Path, count: int, late: float) -> None:
    for number in range(count):
        rng = np.random.default_rng(number)
        material = folder / f"material {chr(97 + number % 5)}"
        material.mkdir(parents=True, exist_ok=True)
        write_log(material / f"take{number}.csv", int(rng.integers(2 * RATE, 10 * RATE)), rng, late)


def write_log(path: Path, rows: int, rng: np.random.Generator, late: float, digits: int = 4) -> None:
    times = (np.arange(rows) / RATE + rng.uniform(0, late, rows)).round(6)
    axes = {f"{axis} [m/s^2]": rng.standard_normal(rows).round(digits) for axis in "xyz"}
    plain = pyarrow.csv.WriteOptions(quoting_style="none", quoting_header="none")
    pyarrow.csv.write_csv(pa.table({"time [s]": times, **axes}), path, plain)
