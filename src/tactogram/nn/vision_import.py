"""Import of torchvision, and of packages that import it: the extra ``vision``.

torchvision's compiled operators need a matching build of torch. With another (usually a CUDA build of torchvision and a
CPU build of torch), ``import torchvision`` fails with "operator torchvision::nms does not exist", as do packages that
import it. Networks, their weight files and the transforms need no compiled operator, so the two operators missing at
import are declared and the import is repeated; ``torchvision.ops.nms`` and ``torchvision.io.read_image`` remain
unavailable (photographs are read with Pillow).
"""

from __future__ import annotations

import sys
import warnings
from functools import cache
from importlib import import_module
from types import ModuleType

import torch

from tactogram.errors import MissingExtraError

OPERATORS = ("nms", "qnms")
"""Operators that torchvision registers at import and that need its compiled library."""


@cache
def torchvision() -> ModuleType:
    """Return torchvision, imported even if its compiled operators do not load."""
    try:
        return _import("torchvision")
    except ModuleNotFoundError as error:
        raise _missing("torchvision", error) from error
    except RuntimeError as error:
        if "torchvision::nms" not in str(error):
            raise _broken("torchvision", error) from error
    for name in [name for name in sys.modules if name.partition(".")[0] == "torchvision"]:
        del sys.modules[name]
    _declare_operators()
    try:
        return _import("torchvision")
    except (ImportError, RuntimeError) as error:
        raise _broken("torchvision", error) from error


def vision_module(name: str) -> ModuleType:
    """Return a module of a package of the extra ``vision``, e.g. ``torchmetrics.image``, imported after torchvision."""
    torchvision()
    try:
        return _import(name)
    except ModuleNotFoundError as error:
        raise _missing(name, error) from error
    except (ImportError, RuntimeError) as error:
        raise _broken(name, error) from error


@cache
def _declare_operators() -> torch.library.Library:
    """Declare the missing operators; they exist as long as the returned library, hence the cache."""
    library = torch.library.Library("torchvision", "FRAGMENT")  # type: ignore[no-untyped-call]
    for name in OPERATORS:
        schema = f"{name}(Tensor dets, Tensor scores, float iou_threshold) -> Tensor"
        library.define(schema)  # type: ignore[no-untyped-call]
    return library


def _import(name: str) -> ModuleType:
    with warnings.catch_warnings():
        # torchvision warns if its library for JPEG and PNG is missing, which is not used here.
        warnings.filterwarnings("ignore", "Failed to load image Python extension", UserWarning)
        return import_module(name)


def _missing(name: str, error: ModuleNotFoundError) -> MissingExtraError:
    return MissingExtraError(
        f"photographs need {name}, and {error.name} is not installed: pip install 'tactogram[vision]'"
    )


def _broken(name: str, error: Exception) -> MissingExtraError:
    return MissingExtraError(
        f"{name} does not import ({type(error).__name__}: {str(error).partition(chr(10))[0]}): install the build "
        "that matches torch, pip install 'tactogram[vision]'"
    )
