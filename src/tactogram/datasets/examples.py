"""Prepared pieces of recordings, as learners see them, and windows cut from them."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import cache
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.labels import Label, label_of
from tactogram.datasets.ratings.ratings import item_of
from tactogram.datasets.recording import RecordingInfo
from tactogram.datasets.scratch import scratch_of
from tactogram.datasets.splits.part_photographs import (
    PhotographRegions,
    by_material,
    cut_out,
    materials_without_recordings,
)
from tactogram.datasets.splits.split import Region, Segment
from tactogram.datasets.store.store import Store
from tactogram.errors import ParameterError
from tactogram.model import Example, ItemRatings, SignalKind
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal
from tactogram.signal.io.atomic import atomic_write


class Examples(Sequence[Example]):
    """Segments of recordings, prepared when first asked for.

    A segment is cut first and prepared then, so that no filter carries one side of a split to the other. What
    was prepared is kept in files and read memory-mapped: memory stays flat.

    Parameters
    ----------
    store : Store
    segments : iterable of Segment
        Usually one part of a `Split`.
    prepare : Prepare
        Stream, axes, band and rate.
    label : str or callable
        What `Example.material` is; see `labels.Label`.
    photographs : iterable of Region, optional
        What this part may use of photographs: one part of `Split.photographs`. They become
        `Example.photographs`, by material, and a recording's own image is cut to what is among them, or left out.
        An own image that is cut has no ``mm_per_pixel``: what was recorded is registered to the whole one.
        By default none is given, and a recording's own image is whole, as in splits of recordings alone.
    cache_dir : Path, optional
        Where prepared signals are kept for the next time. By default a folder that goes with this object.

    Raises
    ------
    ParameterError
        If a segment is of no recording of ``store``, or begins after its end (when it is asked for).
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
        self._cache, self._making = cache_dir, Lock()

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.segments)

    @overload
    def __getitem__(self, place: int) -> Example: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Example]: ...
    def __getitem__(self, place: int | slice) -> Example | Sequence[Example]:
        """Return one example, prepared now if it was not yet."""
        if isinstance(place, slice):
            return [self[i] for i in range(*place.indices(len(self)))]
        info = self.infos[place]
        return Example(
            info.id,
            self._prepared(self.segments[place]),
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
        """Return the photographs of a material that may be used here, decoded when asked for."""
        if self._photographs is None or material is None:
            return PhotographRegions(self.store, ())
        return PhotographRegions(self.store, self._photographs.get(material, ()))

    def _own(self, info: RecordingInfo) -> Region | None:
        """Return what may be used of a recording's own photograph."""
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
        """Whether any of it was made by a formula."""
        return any(info.simulated for info in self.infos)

    def prepare_all(
        self, *, workers: int | None = None, progress: Callable[[int, int], None] | None = None
    ) -> None:
        """Prepare every segment now, on several cores.

        Parameters
        ----------
        workers : int, optional
            Threads; by default one per core. Filters and resampling leave the interpreter's lock.
        progress : callable, optional
            Called with the number prepared and the total.
        """
        with ThreadPoolExecutor(workers or cores()) as pool:
            tasks = [pool.submit(self._prepared, segment) for segment in self.segments]
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
            "prepare": self.prepare.model_dump(mode="json"),
        }
        name = hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:32]
        if self._cache is None or not (self._cache / f"{name}.npy").exists():
            signal = self.prepare.apply(_cut(self.store, segment, stream))
            held = {"rate": signal.rate, "unit": signal.unit, "axes": signal.axes, "domain": signal.domain}
            with (
                self._making
            ):  # the folder is made once a signal could be prepared: a refused setting leaves none
                self._cache = self._cache or scratch_of(self)
            _replace(self._cache / f"{name}.json", json.dumps(held).encode())
            _replace(self._cache / f"{name}.npy", signal.samples)
        held = json.loads((self._cache / f"{name}.json").read_bytes())
        mapped = np.load(self._cache / f"{name}.npy", mmap_mode="r", allow_pickle=False)
        return Signal(mapped, held["rate"], held["unit"], tuple(held["axes"]), held["domain"])


def require_photographs(examples: Sequence[Example]) -> None:
    """Refuse ``examples`` of materials that have no photograph: for models that learn or work from one.

    Raises
    ------
    ParameterError
        One line that names the materials with recordings and no photograph, and, where a store is behind the
        examples, those with photographs and no recording: a name spelt in two ways is among both.
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
        f"these out with --where 'material=!{'|'.join(names)}'"
    )


class _Condition(Mapping[str, Any]):
    """Conditions of a recording, under the names of `CONDITIONS`; the photograph is read on demand."""

    def __init__(self, store: Store, info: RecordingInfo, image: Region | None) -> None:
        self._store, self._id = store, info.id
        known: dict[str, Any] = {
            "speed_mm_s": info.speed_mm_s,
            "force_n": info.force_n,
            "words": dict(info.ratings) or None,
            "image": image,
        }
        self._known = {name: value for name, value in known.items() if value is not None}

    def __getitem__(self, name: str) -> Any:
        if name != "image":
            return self._known[name]
        region: Region = self._known[name]
        image = cut_out(self._store, region)
        # What was recorded begins at the edge of the whole photograph: a part of it is registered to nothing.
        return image if region.whole else Image(image.pixels)

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)


def signal_kind(examples: Sequence[Example], *, simulated: bool | None = None) -> SignalKind:
    """Return what all ``examples`` have in common.

    Parameters
    ----------
    examples : sequence of Example
    simulated : bool, optional
        By default what `Examples` says of itself.

    Raises
    ------
    ParameterError
        If there are none, or they differ in rate, unit, axes or domain; the message says which option helps.
    """
    if not examples:
        raise ParameterError("there are no examples: the part of the split is empty")
    first = examples[0].signal
    for example in examples:
        signal = example.signal
        if signal.rate != first.rate:
            raise ParameterError(
                f"all signals must have one rate, got {first.rate:g} and {signal.rate:g} Hz; "
                "--set prepare.rate=HZ resamples them"
            )
        if signal.axes != first.axes:
            raise ParameterError(
                f"all signals must have the same axes, got {','.join(first.axes)} and {','.join(signal.axes)}; "
                "--set prepare.axes=['NAME'] keeps some, --set prepare.stream=NAME takes one stream"
            )
        if (signal.unit, signal.domain) != (first.unit, first.domain):
            raise ParameterError(
                f"all signals must be of one unit and domain, got {first.unit} over {first.domain} and "
                f"{signal.unit} over {signal.domain}; --set prepare.stream=NAME takes one stream"
            )
    if simulated is None:
        simulated = isinstance(examples, Examples) and examples.simulated
    materials = tuple(sorted({e.material for e in examples if e.material is not None}))
    return SignalKind(first.rate, first.unit, first.axes, materials, simulated, first.domain)


def random_windows(signal: Signal, count: int, length: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Cut ``count`` windows of ``length`` samples at random places; they may overlap.

    Returns
    -------
    float32 array, shape (window, axis, time), in the signal's unit

    Raises
    ------
    ParameterError
        If the signal is shorter than a window.
    """
    starts = rng.integers(0, len(regular_windows(signal, length, 1)), count)
    return regular_windows(signal, length, 1)[starts]


def regular_windows(signal: Signal, length: int, hop: int) -> NDArray[np.float32]:
    """Return the windows of ``length`` samples that begin every ``hop`` samples; an incomplete last one is left out.

    Returns
    -------
    float32 array, shape (window, axis, time), in the signal's unit
        A read-only view: nothing is copied.

    Raises
    ------
    ParameterError
        If the signal is shorter than a window.
    """
    if length < 1 or hop < 1:
        raise ParameterError(f"length and hop must be >= 1, got {length} and {hop}")
    if len(signal) < length:
        raise ParameterError(f"a window of {length} samples is longer than the signal of {len(signal)}")
    windows = np.lib.stride_tricks.sliding_window_view(signal.samples, length, axis=1)
    return windows.transpose(1, 0, 2)[::hop]


def cores() -> int:
    """Return how many cores this process may use."""
    available = getattr(os, "sched_getaffinity", None)
    return len(available(0)) if available else os.cpu_count() or 1


@cache
def _version() -> str:
    """Return the version of this package; looking it up reads a file each time."""
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


def _replace(path: Path, content: bytes | NDArray[np.float32]) -> None:
    with atomic_write(path) as part:  # two threads or processes may prepare the same segment
        if isinstance(content, bytes):
            part.write_bytes(content)
        else:
            np.save(part, content, allow_pickle=False)
