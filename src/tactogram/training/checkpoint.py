"""Checkpoints: a learner's state as one safetensors file, with all but the tensors as JSON in its header."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from tactogram.errors import RunError
from tactogram.signal.io.atomic import atomic_write
from tactogram.text_files import check_regular

VERSION = 1


def save_state(path: Path, state: Mapping[str, Any], facts: Mapping[str, Any] | None = None) -> None:
    """Write ``state`` and ``facts`` to ``path``; a kill or a power cut leaves the old file or the new one.

    ``state`` are nested dicts and lists of tensors, arrays and JSON values, ``facts`` JSON values that describe it.
    """
    tensors: dict[str, Tensor] = {}
    structure = _take_apart(state, "", tensors)
    header = {
        "tactogram": json.dumps({"version": VERSION, "structure": structure, "facts": dict(facts or {})})
    }
    with atomic_write(path, durable=True) as part:
        part.write_bytes(save(tensors, metadata=header))


def load_state(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the state and the facts written by `save_state`; tensors are on the CPU.

    Raises `RunError` if the file is missing, damaged, or of a later version.
    """
    try:
        check_regular(path)
        with safe_open(path, framework="pt") as file:
            header = json.loads((file.metadata() or {})["tactogram"])
            version, structure, facts = header["version"], header["structure"], header["facts"]
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        if version > VERSION:
            raise RunError(f"{path}: written by a later version (format {version}, known {VERSION})")
        return _put_together(structure, tensors), facts
    except KeyError as error:
        raise RunError(f"{path}: damaged: lacks {error}; train again, or use a copy of the run") from error
    except (OSError, SafetensorError, TypeError, ValueError, RecursionError) as error:
        raise RunError(f"{path}: not a readable checkpoint: {error}") from error


def _take_apart(value: Any, path: str, tensors: dict[str, Tensor]) -> Any:
    if isinstance(value, np.ndarray):
        value = torch.from_numpy(np.array(value))
    if isinstance(value, Tensor):
        tensors[path] = value.detach().cpu().clone().contiguous()
        return {"$tensor": path}
    if isinstance(value, Mapping):
        items = [
            [key, _take_apart(inner, f"{path}.{key}" if path else str(key), tensors)]
            for key, inner in value.items()
        ]
        return {"$dict": items}
    if isinstance(value, list | tuple):
        return [_take_apart(inner, f"{path}.{number}", tensors) for number, inner in enumerate(value)]
    if isinstance(value, np.generic):
        return value.item()
    if value is None or isinstance(value, str | int | float | bool):
        return value
    raise RunError(f"state at {path} must be a tensor or a JSON value, got {type(value).__name__}")


def _put_together(value: Any, tensors: Mapping[str, Tensor]) -> Any:
    if isinstance(value, dict):
        if "$tensor" in value:
            return tensors[value["$tensor"]]
        return {key: _put_together(inner, tensors) for key, inner in value["$dict"]}
    if isinstance(value, list):
        return [_put_together(inner, tensors) for inner in value]
    return value
