"""Examples: prepared segments of recordings, and windows of them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import cache
from importlib.metadata import version
from mmap import ACCESS_READ, mmap
from pathlib import Path
from threading import Lock
from typing import Any, overload

import numpy as np

from tactogram.datasets.recording import Label, RecordingInfo, item_of, label_of
from tactogram.datasets.scratch import scratch_of
from tactogram.datasets.splits.photograph_splitting import (
    PhotographRegions,
    by_material,
    cut_out,
    materials_without_recordings,
)
from tactogram.datasets.splits.split import Region, Segment, Split
from tactogram.datasets.store.store import Store
from tactogram.errors import ParameterError
from tactogram.model import Example, ItemRatings, SignalKind
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal
from tactogram.signal.io.atomic import atomic_write


class Examples(Sequence[Example]):
    """Segments of recordings, prepared on first use.

    A segment is cut before it is prepared, so that no filter carries one part of a split into another. Prepared signals
    are stored in files and memory-mapped: memory stays flat.

    Parameters
    ----------
    store : Store
    segments : iterable of Segment
        Usually one part of a `Split`.
    prepare : Preparation
    label : str or callable
        Class of a recording, `Example.material`; see `labels.Label`.
    photographs : iterable of Region, optional
        Photographs that this part may use: one part of `Split.photographs`. They become `Example.photographs`, by
        material, and a recording's own image is cut to its region among them, or left out. A cut image has no
        ``mm_per_pixel``, since the recording is registered to the whole one. By default there are none, and own images
        are whole, as in splits of recordings alone.
    cache_dir : Path, optional
        Folder of prepared signals for reuse. By default a folder that is removed with this object.
    """

    def __init__(
        self,
        store: Store,
        segments: Iterable[Segment],
        prepare: Preparation,
        *,
        label: Label = "material",
        photographs: Iterable[Region] | None = None,
        cache_dir: Path | None = None,
    ) -> None:
        regions = None if photographs is None else tuple(photographs)
        self._photographs = None if regions is None else by_material(store, regions)
        self._region_of = {region.key: region for region in reversed(regions or ())}
        self.store, self.segments, self.prepare, self.label = store, tuple(segments), prepare, label
        self.infos: tuple[RecordingInfo, ...] = tuple(store.info(segment.id) for segment in self.segments)
        self._settings = prepare.model_dump(mode="json")
        self._cache, self._making = cache_dir, Lock()

    def __len__(self) -> int:
        return len(self.segments)

    @overload
    def __getitem__(self, index: int) -> Example: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Example]: ...
    def __getitem__(self, index: int | slice) -> Example | Sequence[Example]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        info = self.infos[index]
        return Example(
            info.id,
            self._prepared(self.segments[index]),
            label_of(info, self.label),
            _Condition(self.store, info, self._own(info)),
            self.photographs_of(info.material),
            item := item_of(info),
            self._rated(item),
        )

    def _rated(self, item: str | None) -> ItemRatings | None:
        ratings = self.store.ratings
        return ratings.rated(item) if ratings is not None and item is not None and item in ratings else None

    def photographs_of(self, material: str | None) -> PhotographRegions:
        """Return the photographs of a material that may be used here, decoded on demand."""
        if self._photographs is None or material is None:
            return PhotographRegions(self.store, ())
        return PhotographRegions(self.store, self._photographs.get(material, ()))

    def _own(self, info: RecordingInfo) -> Region | None:
        """Return the usable region of a recording's own photograph."""
        key = self.store.image_id(info.id)
        if key is None:
            return None
        return Region(key) if self._photographs is None else self._region_of.get(key)

    @property
    def materials(self) -> tuple[str, ...]:
        """The classes, sorted."""
        return tuple(sorted({name for info in self.infos if (name := label_of(info, self.label))}))

    @property
    def simulated(self) -> bool:
        """Whether any of it was computed rather than measured."""
        return any(info.simulated for info in self.infos)

    def prepare_all(
        self,
        *,
        workers: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Prepare every segment now, in threads, by default one per core, since filters release the interpreter's lock.

        ``progress`` is called with the number of prepared segments and their total.
        """
        stored = sorted(self.segments, key=lambda segment: self.store.place(segment.id))
        with ThreadPoolExecutor(workers or cores()) as pool:
            tasks = [pool.submit(self._prepared, segment) for segment in stored]
            try:
                for done, task in enumerate(as_completed(tasks), 1):
                    task.result()
                    if progress is not None:
                        progress(done, len(tasks))
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def _prepared(self, segment: Segment) -> Signal:
        stream = self.prepare.stream_of(self.store.streams_of(segment.id))
        facts = {
            "version": _version(),
            "segment": [segment.id, segment.start_s, segment.stop_s, stream],
            "prepare": self._settings,
        }
        name = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:32]
        if self._cache is None or not (self._cache / f"{name}.f32").exists():
            signal = self.prepare.apply(_cut(self.store, segment, stream))
            samples = np.ascontiguousarray(signal.samples)
            kind = {"rate": signal.rate, "unit": signal.unit, "axes": signal.axes, "domain": signal.domain}
            # The folder is made after a signal was prepared: refused settings leave none.
            with self._making:
                self._cache = self._cache or scratch_of(self)
            _replace(self._cache / f"{name}.json", json.dumps(kind).encode())
            _replace(self._cache / f"{name}.f32", samples.data)
        kind = json.loads((self._cache / f"{name}.json").read_bytes())
        with (self._cache / f"{name}.f32").open("rb") as file:
            mapped = mmap(file.fileno(), 0, access=ACCESS_READ)
        axes = tuple(kind["axes"])
        samples = np.frombuffer(mapped, np.float32).reshape(len(axes), -1)
        return Signal(samples, kind["rate"], kind["unit"], axes, kind["domain"])


def part_examples(
    store: Store,
    split: Split,
    part: str,
    prepare: Preparation,
    *,
    label: Label,
    cache_dir: Path | None = None,
) -> Examples:
    """Return one part of ``split``, with its photographs if these were split, too."""
    photographs = split.photographs.get(part, ()) if split.photographs else None
    return Examples(
        store, split.parts[part], prepare, label=label, photographs=photographs, cache_dir=cache_dir
    )


def require_photographs(examples: Sequence[Example]) -> None:
    """Raise a `ParameterError` if ``examples`` have a material without photograph: for models that need one.

    It names these materials and, if there is a store, those with photographs but no recording: a name spelt in two ways
    is in both lists.
    """
    if isinstance(examples, Examples):
        lacking = {
            info.material for info in examples.infos if not len(examples.photographs_of(info.material))
        }
        unused = materials_without_recordings(examples.store)
    else:
        lacking, unused = {e.material for e in examples if not len(e.photographs)}, ()
    if not lacking:
        return
    names = sorted(name or "(no material)" for name in lacking)
    also = f" (and no recording of {', '.join(unused)})" if unused else ""
    raise ParameterError(
        f"each material must have a photograph, got none of {', '.join(names)}{also}; add some to the data, or leave "
        f"these out with where material=!{'|'.join(names)}"
    )


class _Condition(Mapping[str, Any]):
    """Conditions of a recording, by names of `tactogram.model.condition_types`; the photograph is read on demand."""

    def __init__(self, store: Store, info: RecordingInfo, image: Region | None) -> None:
        self._store = store
        values: dict[str, Any] = {
            "speed_mm_s": info.speed_mm_s,
            "force_n": info.force_n,
            "contactor": info.contactor,
            "words": dict(info.ratings) or None,
            "image": image,
        }
        self._values = {name: value for name, value in values.items() if value is not None}

    def __getitem__(self, name: str) -> Any:
        if name != "image":
            return self._values[name]
        region: Region = self._values[name]
        image = cut_out(self._store, region)
        # The recording is registered to the whole photograph: a part of it has no scale.
        return image if region.whole else Image(image.pixels)

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


def signal_kind(examples: Sequence[Example], *, simulated: bool | None = None) -> SignalKind:
    """Return the rate, unit, axes and domain of all ``examples``, with their materials.

    ``simulated`` is by default that of `Examples`. A `ParameterError` if there are none, or they differ.
    """
    if not examples:
        raise ParameterError("there are no examples: the part of the split is empty")
    first = examples[0].signal
    for example in examples:
        signal = example.signal
        if signal.rate != first.rate:
            raise ParameterError(
                f"all signals must have one rate, got {first.rate:g} and {signal.rate:g} Hz; "
                "prepare.rate=HZ resamples them"
            )
        if signal.axes != first.axes:
            raise ParameterError(
                f"all signals must have the same axes, got {','.join(first.axes)} and {','.join(signal.axes)}; "
                "prepare.axes=['NAME'] selects some, prepare.stream=NAME one stream"
            )
        if (signal.unit, signal.domain) != (first.unit, first.domain):
            raise ParameterError(
                f"all signals must be of one unit and domain, got {first.unit} over {first.domain} and "
                f"{signal.unit} over {signal.domain}; prepare.stream=NAME selects one stream"
            )
    if simulated is None:
        simulated = isinstance(examples, Examples) and examples.simulated
    materials = tuple(sorted({e.material for e in examples if e.material is not None}))
    return SignalKind(first.rate, first.unit, first.axes, materials, simulated, first.domain)


def cores() -> int:
    """Return the number of cores that this process may use."""
    available = getattr(os, "sched_getaffinity", None)
    return len(available(0)) if available else os.cpu_count() or 1


@cache
def _version() -> str:
    """Return the version of this package, which is read from a file."""
    return version("tactogram")


def _cut(store: Store, segment: Segment, stream: str) -> Signal:
    rate, length = store.rate(segment.id, stream), store.length(segment.id, stream)
    start = round(segment.start_s * rate)
    stop = length if segment.stop_s is None else min(round(segment.stop_s * rate), length)
    if start >= stop:
        raise ParameterError(
            f"segment of {segment.id} must begin within its {length / rate:g} s and hold a sample, "
            f"got {segment.start_s:g} to {segment.stop_s} s"
        )
    return store.signal(segment.id, stream, start=start, stop=stop)


def _replace(path: Path, content: bytes | memoryview) -> None:
    with atomic_write(path) as part:  # threads or processes may prepare the same segment
        part.write_bytes(content)
