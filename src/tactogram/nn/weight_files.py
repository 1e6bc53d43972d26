"""Published weights from local files: nothing is downloaded, and no file can run code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from torch import Tensor

from tactogram.errors import DataError


def weight_file(path: Path | str, url: str, *, of: str, option: str) -> Path:
    """Return the file of a network's weights: ``path``, or if empty the file of ``url`` in torch's cache.

    ``of`` (the network) and ``option`` (the setting of ``path``) are named in errors.
    """
    if path:
        file = Path(path).expanduser()
        if not file.is_file():
            raise DataError(f"{file}: no weights of {of} there; set {option} to {url.rpartition('/')[2]}")
        return file
    file = Path(torch.hub.get_dir()) / "checkpoints" / url.rpartition("/")[2]
    if not file.is_file():
        raise DataError(
            f"weights of {of} are missing: put {file.name} into {file.parent}, or set {option} to the file"
        )
    return file


def read_weights(file: Path) -> Mapping[str, Tensor]:
    """Return the tensors in a ``.pth`` or ``.safetensors`` file by name; a file of anything else is refused."""
    try:
        if file.suffix == ".safetensors":
            from safetensors.torch import load_file

            return load_file(file)
        state: Mapping[str, Tensor] = torch.load(file, map_location="cpu", weights_only=True)
    except Exception as error:  # of many kinds
        line = str(error).partition("\n")[0]
        raise DataError(f"{file}: not a readable file of weights: {line[:120]}") from error
    if not (isinstance(state, Mapping) and all(isinstance(value, Tensor) for value in state.values())):
        raise DataError(f"{file}: not a file of weights: expected tensors by name")
    return state
