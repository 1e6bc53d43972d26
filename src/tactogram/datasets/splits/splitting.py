"""Ways to make a split: at random, in order, in folds, or by blocks of long takes."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, get_args

import numpy as np

from tactogram.datasets.recording import Label, RecordingInfo, label_of, natural_key
from tactogram.datasets.splits.split import By, Segment, Split
from tactogram.errors import ParameterError, Remedy


def split_fractions(
    index: Iterable[RecordingInfo],
    *,
    by: By = "recording",
    test: float = 0.2,
    validation: float = 0.1,
    seed: int,
    label: Label = "material",
) -> Split:
    """Draw the parts at random.

    Raises `ParameterError` if a share is invalid, or there are too few recordings or groups.

    Parameters
    ----------
    index : iterable of RecordingInfo
        Usually ``store.index``.
    by : str
        What stays in one part. By recording, each class is split separately, so that all parts have all classes if
        there are enough recordings.
    test, validation : float, 0 to 1
        Shares of the recordings (by recording) or of the groups; at least one if above 0.
    label : str or callable
        Class of a recording.
    """
    if not (test >= 0 and validation >= 0 and test + validation < 1):
        raise ParameterError(f"test + validation must be below 1 and each >= 0, got {test} + {validation}")
    infos = list(index)
    shares = {part: share for part, share in (("test", test), ("validation", validation)) if share > 0}
    random = np.random.default_rng(seed)
    parts: dict[str, list[str]] = {"train": [], "test": [], "validation": []}
    strata = _strata(infos, label) if by == "recording" else {"": _members(infos, by)}
    for members in strata.values():
        names = random.permutation(sorted(members)).tolist()
        enough = len(names) > len(shares)
        for done, (part, share) in enumerate(shares.items(), 1):
            # One is reserved for each later part; if there are too few, train comes first, then test.
            reserved = 1 + (len(shares) - done if enough else 0)
            count = max(min(max(round(share * len(members)), 1), len(names) - reserved), 0)
            parts[part] += [id for name in names[:count] for id in members[name]]
            names = names[count:]
        parts["train"] += [id for name in names for id in members[name]]
    for part in shares:
        if not parts[part]:
            most = max(len(members) for members in strata.values())
            raise _too_few(f"{part} would be empty", by, len(shares) + 1, most)
    return _whole(parts, infos, by, seed)


def split_last(
    index: Iterable[RecordingInfo], n: int, *, validation: int = 0, label: Label = "material"
) -> Split:
    """Test on the last ``n`` recordings of each class, and validate on the ``validation`` before them.

    The order is that of ``labels["recording"]``, then of the source path, numbers in order. A class with too few
    recordings is a `ParameterError`.
    """
    if n < 1 or validation < 0:
        raise ParameterError.must("n", f"be >= 1 and validation >= 0, got {n} and {validation}")
    infos = list(index)
    parts: dict[str, list[str]] = {"train": [], "test": [], "validation": []}
    for material, members in _strata(sorted(infos, key=natural_order), label).items():
        ids = list(members)
        if len(ids) <= n + validation:
            raise ParameterError(
                f"{material or 'no material'} must have more than {n + validation} recordings, got {len(ids)}"
            )
        end = len(ids) - n
        parts["test"] += ids[end:]
        parts["validation"] += ids[end - validation : end]
        parts["train"] += ids[: end - validation]
    return _whole(parts, infos, "order", None)


def kfold(
    index: Iterable[RecordingInfo],
    folds: int,
    *,
    by: By = "recording",
    seed: int,
    validation: float = 0.0,
    label: Label = "material",
) -> list[Split]:
    """Deal recordings or groups to ``folds`` (>= 2) test parts; each is tested exactly once.

    By recording, each class is dealt separately, so that every fold tests every class. ``validation`` is the share of
    each training part for validation; at least one of each class, or one group.

    Raises `ParameterError` if there are fewer recordings of a class, or groups, than folds.
    """
    if folds < 2:
        raise ParameterError.must("folds", "be >= 2", folds)
    if not 0 <= validation < 1:
        raise ParameterError.must("validation", "be >= 0 and below 1", validation)
    infos = list(index)
    random = np.random.default_rng(seed)
    strata = _strata(infos, label) if by == "recording" else {"": _members(infos, by)}
    fold_of: dict[str, int] = {}
    dealt = 0
    for material, members in strata.items():
        if len(members) < folds:
            raise _too_few(material, by, folds, len(members))
        for name in random.permutation(sorted(members)).tolist():
            fold_of |= dict.fromkeys(members[name], dealt % folds)
            dealt += 1
    splits = []
    for fold, child in enumerate(random.spawn(folds)):
        parts: dict[str, list[str]] = {"train": [], "validation": []}
        parts["test"] = [info.id for info in infos if fold_of[info.id] == fold]
        for members in strata.values():
            rest = [name for name in members if fold_of[members[name][0]] != fold]
            names = child.permutation(sorted(rest)).tolist()
            count = min(max(round(validation * len(names)), 1), len(names) - 1) if validation else 0
            parts["validation"] += [id for name in names[:count] for id in members[name]]
            parts["train"] += [id for name in names[count:] for id in members[name]]
        splits.append(_whole(parts, infos, by, seed))
    return splits


def contiguous_blocks(
    index: Iterable[RecordingInfo], seconds: Mapping[str, float], *, blocks: int = 10, gap_s: float
) -> list[Split]:
    """Cut each recording into ``blocks`` (>= 2) equal parts in time; split k tests part k of every recording.

    For few and long takes: the closest fair reading of "all data was divided into ten parts" (Saga et al., "Machine
    Learning-based Classification and Generation of Vibrotactile Information", Sec. II-C). ``seconds`` are the durations
    by id; ``gap_s`` is left out of training on both sides of the tested part: the length of one window.

    Raises `ParameterError` if a recording is too short to leave anything for training.
    """
    if blocks < 2:
        raise ParameterError.must("blocks", "be >= 2", blocks)
    if not 0 <= gap_s < math.inf:
        raise ParameterError.must("gap_s", "be >= 0", gap_s)
    infos = list(index)
    splits = []
    for block in range(blocks):
        train, test = [], []
        for info in infos:
            length = seconds[info.id]
            start, stop = length * block / blocks, length * (block + 1) / blocks
            test.append(Segment(info.id, start, stop if block < blocks - 1 else None))
            sides = []
            if block and start - gap_s > 0:
                sides.append(Segment(info.id, 0.0, start - gap_s))
            if block < blocks - 1 and stop + gap_s < length:
                sides.append(Segment(info.id, stop + gap_s, None))
            if not sides:
                raise ParameterError(
                    f"{info.source or info.id} of {length:g} s is too short for {blocks} blocks with gaps "
                    f"of {gap_s:g} s; split by recording"
                )
            train += sides
        splits.append(Split(tuple(train), (), tuple(test), "block", None, gap_s))
    return splits


def natural_order(info: RecordingInfo) -> list[list[tuple[int, int, str]]]:
    """Return the key that sorts recordings by number, then by source."""
    return [natural_key(text) for text in (info.labels.get("recording", ""), info.source or info.id)]


def _strata(infos: Sequence[RecordingInfo], label: Label) -> dict[str, dict[str, list[str]]]:
    """Return the recordings of each class, each a group of its own."""
    strata: dict[str, dict[str, list[str]]] = defaultdict(dict)
    for info in infos:
        strata[label_of(info, label) or ""][info.id] = [info.id]
    return dict(sorted(strata.items()))


def _members(infos: Sequence[RecordingInfo], by: By) -> dict[str, list[str]]:
    if by not in get_args(By):
        raise ParameterError.one_of("by", get_args(By), by)
    members: dict[str, list[str]] = defaultdict(list)
    for info in infos:
        members[_group(info, by)].append(info.id)
    return dict(members)


def _group(info: RecordingInfo, by: By) -> str:
    if by == "condition":
        named: Mapping[str, Any] = {
            "speed": info.speed_mm_s,
            "force": info.force_n,
            "direction": info.direction_deg,
            "contactor": info.contactor,
        }
        known = [f"{name}={value}" for name, value in named.items() if value is not None]
        if known:
            return " ".join(known)
    else:
        value = info.id if by == "recording" else getattr(info, by)
        if value is not None:
            return str(value)
    raise ParameterError(f"{info.source or info.id} has no {by}: split by recording, or add it to the data")


def _whole(
    parts: Mapping[str, Sequence[str]],
    infos: Sequence[RecordingInfo],
    by: By | Literal["order"],
    seed: int | None,
) -> Split:
    """Return the split of whole recordings, each part in the order of the index."""
    order = {info.id: i for i, info in enumerate(infos)}
    segments = {
        part: tuple(Segment(id) for id in sorted(ids, key=order.__getitem__)) for part, ids in parts.items()
    }
    groups = {} if by in ("recording", "order") else {info.id: _group(info, by) for info in infos}  # type: ignore[arg-type]
    return Split(segments["train"], segments["validation"], segments["test"], by, seed, 0.0, groups)


def _too_few(where: str, by: str, needed: int, got: int) -> ParameterError:
    blocks = Remedy("test on a part of each instead,", "split", "blocks")
    problem = f"needs at least {needed} {by}s{' of a class' * (by == 'recording')}, got {got}"
    return ParameterError(where, problem, remedy=blocks if by == "recording" else "split by recording")
