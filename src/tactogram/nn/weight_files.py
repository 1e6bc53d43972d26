"""Published weights from files that are already here: nothing is downloaded, and no file can run code."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from torch import Tensor

from tactogram.errors import DataError


def weight_file(given: Path | str, url: str, *, of: str, option: str) -> Path:
    """Return where the weights of a network are: the file that was given, else in torch's cache.

    Parameters
    ----------
    given : path or ""
    url : str
        Where they are published; the last part is what the file is called in the cache.
    of : str
        What to call the network in errors.
    option : str
        What a file is given by.

    Raises
    ------
    DataError
        One line that says where it was looked for.
    """
    if given:
        file = Path(given).expanduser()
        if not file.is_file():
            raise DataError(
                f"{file}: no weights of {of} there; give {option} the file {url.rpartition('/')[2]}"
            )
        return file
    file = Path(torch.hub.get_dir()) / "checkpoints" / url.rpartition("/")[2]
    if not file.is_file():
        raise DataError(
            f"weights of {of} are not here: put {file.name} into {file.parent}, or give {option} the file"
        )
    return file


def read_weights(file: Path) -> Mapping[str, Tensor]:
    """Return the tensors in a ``.pth`` or ``.safetensors`` file by name.

    Raises
    ------
    DataError
        If it is no such file, or holds anything but tensors.
    """
    try:
        if file.suffix == ".safetensors":
            from safetensors.torch import load_file

            return load_file(file)
        state: Mapping[str, Tensor] = torch.load(file, map_location="cpu", weights_only=True)
    except Exception as error:  # of many kinds, all of them: not a file of weights
        line = str(error).partition("\n")[0]
        raise DataError(f"{file}: not a readable file of weights: {line[:120]}") from error
    if not (isinstance(state, Mapping) and all(isinstance(value, Tensor) for value in state.values())):
        raise DataError(f"{file}: not a file of weights: expected tensors by name")
    return state
