"""Stores in LeRobot's layout, version 3.0: an episode is a recording, a frame holds a window of every stream.

Streams have their own rates; a frame has the samples from its time on until the next frame's. `data/` and
`meta/episodes/` are Parquet, with the paths and columns of the format's reference implementation.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactogram.datasets import Store
from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.data.hub_layout import card_head, origin
from tactogram.workflows.progress import ProgressCallback

VERSION = "v3.0"
CHUNK = 1000
"""Files in a folder ``chunk-NNN``."""
FILE_MB = 100
"""Size of a file after which another begins."""
PLACE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
INDEX = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
"""Columns that every data set has."""
ACTIONS = ("speed_mm_s", "force_n")
TINY = 1e-9

Stats = dict[str, dict[str, NDArray[np.float64]]]


@dataclass(frozen=True)
class Feature:
    """A stream in frames: ``samples`` of each axis."""

    stream: str
    rate: float
    unit: str
    axes: tuple[str, ...]
    fps: int

    @property
    def samples(self) -> int:
        """Samples of a frame."""
        return max(1, math.ceil(self.rate / self.fps - TINY))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a frame."""
        return (self.samples,) if len(self.axes) == 1 else (len(self.axes), self.samples)

    def starts(self, frames: int) -> NDArray[np.int64]:
        """Return the first sample of each frame."""
        return np.floor(np.arange(frames) * self.rate / self.fps + TINY).astype(np.int64)

    def frames(self, length: int) -> int:
        """Return the frames whose samples all are among ``length``."""
        most = max(0, math.ceil((length - self.samples + 1) * self.fps / self.rate))
        starts = self.starts(most)
        return int(np.count_nonzero(starts + self.samples <= length))

    def windows(self, samples: NDArray[np.float32], frames: int) -> NDArray[np.float32]:
        """Return the frames of samples, (axis, time): (frame, *shape)."""
        places = self.starts(frames)[:, None] + np.arange(self.samples)
        return np.ascontiguousarray(samples[:, places].swapaxes(0, 1)).reshape(frames, *self.shape)


def write_lerobot_dataset(
    store: Store, folder: Path, *, fps: int, progress: ProgressCallback
) -> dict[str, Any]:
    """Write a store into ``folder``, and return the number of episodes and frames, and the streams left out.

    Raises `ParameterError` if no stream is in every recording at one rate, over time, or a recording is shorter than a
    frame.
    """
    features, left_out = _features(store, fps)
    actions = tuple(name for name in ACTIONS if all(getattr(info, name) is not None for info in store.index))
    described = _described(features, actions)
    tasks = list(dict.fromkeys(_task(info.material) for info in store.index))
    writer = _DataWriter(folder)
    episodes: list[dict[str, Any]] = []
    every: list[Stats] = []
    index = 0
    for number, recording in enumerate(store.index):
        progress("export", number, len(store), recording.id)
        signals = {name: store.signal(recording.id, name).samples for name in features}
        frames = min(each.frames(signals[name].shape[1]) for name, each in features.items())
        if frames < 1:
            raise ParameterError(f"recording {recording.id} is shorter than a frame of 1/{fps} s; raise fps")
        values: dict[str, NDArray[Any]] = {
            f"observation.{name}": each.windows(signals[name], frames) for name, each in features.items()
        }
        if actions:
            row = np.array([getattr(recording, name) for name in actions], np.float32)
            values["action"] = np.repeat(row[None], frames, axis=0)
        counting = np.arange(frames)
        task = tasks.index(_task(recording.material))
        numbers = (counting / fps, counting, np.full(frames, number), index + counting, np.full(frames, task))
        values |= {
            name: column.astype(kind)[:, None]
            for (name, kind), column in zip(INDEX.items(), numbers, strict=True)
        }
        place = writer.write(_table(values, described))
        every.append(_stats(values))
        episodes.append(
            {
                "episode_index": number,
                "tasks": [tasks[task]],
                "length": frames,
                "data/chunk_index": place[0],
                "data/file_index": place[1],
                "dataset_from_index": index,
                "dataset_to_index": index + frames,
                "meta/episodes/chunk_index": 0,
                "meta/episodes/file_index": 0,
                **{
                    f"stats/{feature}/{name}": value.tolist()
                    for feature, found in every[-1].items()
                    for name, value in found.items()
                },
            }
        )
        index += frames
    writer.close()
    progress("export", len(store), len(store))
    info = {
        "codebase_version": VERSION,
        "robot_type": None,
        "total_episodes": len(episodes),
        "total_frames": index,
        "total_tasks": len(tasks),
        "chunks_size": CHUNK,
        "data_files_size_in_mb": FILE_MB,
        "video_files_size_in_mb": 0,
        "fps": fps,
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": f"data/{PLACE}",
        "video_path": None,
        "features": described,
    }
    _write_meta(folder, info, episodes, tasks, _joined(every))
    write_text(folder / "README.md", _card(store, info, features, left_out))
    return {"episodes": len(episodes), "frames": index, "streams": list(features), "left_out": left_out}


def _features(store: Store, fps: int) -> tuple[dict[str, Feature], dict[str, str]]:
    """Return the streams that every recording has alike, and why others are left out."""
    found, left_out = {}, {}
    for name, facts in store.streams.items():
        rates, axes = set(), set()
        lacking = 0
        for info in store.index:
            if name in store.streams_of(info.id):
                rates.add(store.rate(info.id, name))
                axes.add(store.signal(info.id, name, stop=1).axes)
            else:
                lacking += 1
        if facts.domain != "time":
            left_out[name] = "over displacement"
        elif lacking:
            left_out[name] = f"{lacking} recordings lack it"
        elif len(rates) > 1 or len(axes) > 1:
            left_out[name] = "its rate or axes differ between recordings"
        else:
            found[name] = Feature(name, rates.pop(), facts.unit, axes.pop(), fps)
    if not found:
        reasons = "; ".join(f"{name}: {why}" for name, why in left_out.items())
        raise ParameterError(f"no stream is alike in all recordings: {reasons}")
    return found, left_out


def _described(features: Mapping[str, Feature], actions: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {
        f"observation.{name}": {
            "dtype": "float32",
            "shape": list(each.shape),
            "names": None,
            "info": {"rate_hz": each.rate, "unit": each.unit, "axes": list(each.axes)},
        }
        for name, each in features.items()
    }
    if actions:
        found["action"] = {"dtype": "float32", "shape": [len(actions)], "names": list(actions)}
    return found | {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in INDEX.items()}


def _task(material: str | None) -> str:
    return f"Stroke {material}." if material else "Stroke the surface."


class _DataWriter:
    """Files of frames; an episode is in one of them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.number, self.bytes = folder / "data", 0, 0
        self.file: pq.ParquetWriter | None = None

    def write(self, table: pa.Table) -> tuple[int, int]:
        """Write an episode; return the numbers of chunk and file."""
        if self.file is not None and self.bytes + table.nbytes > FILE_MB * 2**20:
            self.close()
            self.number, self.bytes = self.number + 1, 0
        chunk, file = divmod(self.number, CHUNK)
        if self.file is None:
            path = self.folder / PLACE.format(chunk_index=chunk, file_index=file)
            path.parent.mkdir(parents=True, exist_ok=True)
            self.file = pq.ParquetWriter(path, table.schema)
        self.file.write_table(table)
        self.bytes += table.nbytes
        return chunk, file

    def close(self) -> None:
        """End the current file."""
        if self.file is not None:
            self.file.close()
            self.file = None


def _table(values: Mapping[str, NDArray[Any]], described: Mapping[str, Mapping[str, Any]]) -> pa.Table:
    """Return frames as a table: numbers, lists or lists of lists, by shape."""
    columns = {}
    for name, facts in described.items():
        x = values[name]
        column = pa.array(x.reshape(-1))
        if facts["shape"] != [1]:
            for size in reversed(x.shape[1:]):
                offsets = pa.array(np.arange(0, len(column) + 1, size, dtype=np.int32))
                column = pa.ListArray.from_arrays(offsets, column)
        columns[name] = column
    return pa.table(columns)


def _stats(values: Mapping[str, NDArray[Any]]) -> Stats:
    """Return least, greatest, mean and standard deviation of each number of a frame, and the number of frames."""
    found = {}
    for name, column in values.items():
        x = column.astype(np.float64)
        found[name] = {
            "min": x.min(0),
            "max": x.max(0),
            "mean": x.mean(0),
            "std": x.std(0),
            "count": np.array([len(x)]),
        }
    return found


def _joined(every: list[Stats]) -> Stats:
    joined = {}
    for name in every[0]:
        parts = {key: np.stack([stats[name][key] for stats in every]) for key in every[0][name]}
        weights = parts["count"].reshape(-1, *[1] * (parts["mean"].ndim - 1)) / parts["count"].sum()
        mean = (weights * parts["mean"]).sum(0)
        variance = (weights * (parts["std"] ** 2 + (parts["mean"] - mean) ** 2)).sum(0)
        joined[name] = {
            "min": parts["min"].min(0),
            "max": parts["max"].max(0),
            "mean": mean,
            "std": np.sqrt(variance),
            "count": parts["count"].sum(0),
        }
    return joined


def _write_meta(
    folder: Path, info: Mapping[str, Any], episodes: list[dict[str, Any]], tasks: list[str], stats: Stats
) -> None:
    import pandas

    path = folder / "meta" / "episodes" / PLACE.format(chunk_index=0, file_index=0)
    path.parent.mkdir(parents=True)
    pq.write_table(pa.Table.from_pylist(episodes), path)
    table = pandas.DataFrame({"task_index": range(len(tasks))}, index=pandas.Index(tasks, name="task"))
    table.to_parquet(folder / "meta" / "tasks.parquet")  # readers look tasks up in the table's index
    plain = {name: {key: value.tolist() for key, value in found.items()} for name, found in stats.items()}
    for name, values in (("info", info), ("stats", plain)):
        write_text(folder / "meta" / f"{name}.json", json.dumps(values, indent=4, ensure_ascii=False) + "\n")


def _card(
    store: Store, info: Mapping[str, Any], features: Mapping[str, Feature], left_out: Mapping[str, str]
) -> str:
    head = card_head(
        store,
        tags=["LeRobot"],
        task_categories=["robotics"],
        configs=[{"config_name": "default", "data_files": "data/*/*.parquet"}],
    )
    rows = [
        f"| observation.{name} | {each.unit} | {each.rate:g} Hz | {', '.join(each.axes)} | {each.samples} |"
        for name, each in features.items()
    ]
    without = "".join(f"\nLeft out: {name} ({why})." for name, why in left_out.items())
    table = "\n".join(
        ("| feature | unit | rate | axes | samples per frame |", "| --- | --- | --- | --- | --- |", *rows)
    )
    return f"""{head}
# {store.name}

{origin(store)}

In LeRobot's layout {VERSION}: an episode is a recording, and a frame of 1/{info["fps"]} s holds the samples from its
time on until the next frame's. `action` is the nominal stroking speed (mm/s) and normal force (N) of the recording.

{table}
{without}

```json
{json.dumps(info, indent=4, ensure_ascii=False)}
```
"""
