"""Installation check: packages, missing extras with their purpose, and the compute device."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, metadata, requires, version
from importlib.util import find_spec
from typing import Any

from packaging.requirements import Requirement

from tactogram.errors import MissingExtraError

EXTRAS = {
    "dev": "tests, style, types, benchmarks",
    "docs": "building the documentation",
    "text": "materials described in English",
    "formats": "workbooks, TDMS, HDF5, HEIC, other encodings",
    "statistics": "agreement of raters, tests of ranks",
    "devices": "serial boards, audio displays, OSC",
    "lsl": "Lab Streaming Layer",
    "daq": "National Instruments devices",
    "dwf": "Digilent Analog Discovery",
    "simulate": "simulated surfaces and raters, the demo",
    "playback": "live output to displays, streams under a finger",
    "capture": "sensors, sessions, live recognition",
    "study": "experiments with people",
    "studio": "studio and studies in the browser",
    "benchmark": "tasks, published data sets, tables and figures",
    "ray": "tasks on several machines",
    "vision": "photographs: pretrained trunks, LPIPS, FID, Grad-CAM",
}


def doctor() -> dict[str, Any]:
    """Check the installation: packages, missing extras with their purpose, and the compute device.

    Returns
    -------
    dict
        ``tactogram``, ``python``, ``platform``, ``cores``, ``memory_gib``, ``device``, ``threads``, ``packages`` (name
        to version or None), ``extras`` (name to ``for`` and ``missing``), ``weights`` (published weights that no
        package contains: ``network``, ``for``, ``state``, ``file`` in torch's cache, ``sha256_start``, ``url``),
        ``problems`` (sentences).
    """
    import torch

    from tactogram.nn.weight_files import PRETRAINED

    core: dict[str, str | None] = {}
    provided = metadata("tactogram").get_all("Provides-Extra") or []
    extras: dict[str, dict[str, Any]] = {
        name: {"for": what, "missing": []} for name, what in EXTRAS.items() if name in provided
    }
    for text in requires("tactogram") or []:
        need = Requirement(text)
        if need.marker is None:
            core[need.name] = _version(need.name)
        for name, extra in extras.items():
            if _only_for(need, name) and _version(need.name) is None:
                extra["missing"].append(need.name)
    if torch.cuda.is_available():
        device = torch.cuda.get_device_name()
    else:
        device = "mps" if torch.backends.mps.is_available() else "cpu"
    return {
        "tactogram": _version("tactogram"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "memory_gib": _memory_gib(),
        "device": device,
        "threads": torch.get_num_threads(),
        "packages": core,
        "extras": extras,
        "weights": [
            {
                "network": weights.network,
                "for": weights.used_for,
                "state": weights.state(),
                "file": str(weights.cached),
                "sha256_start": weights.sha256_start,
                "url": weights.url,
            }
            for weights in PRETRAINED
        ],
        "problems": _problems(core),
    }


def _only_for(need: Requirement, extra: str) -> bool:
    """Whether ``need`` comes with ``extra`` and not without."""
    return bool(
        need.marker and need.marker.evaluate({"extra": extra}) and not need.marker.evaluate({"extra": ""})
    )


def _problems(core: dict[str, str | None]) -> list[str]:
    problems = [f"{name} is missing: install tactogram again" for name, got in core.items() if got is None]
    if os.environ.get("OMP_WAIT_POLICY", "").upper() != "PASSIVE":
        problems.append(
            "OMP_WAIT_POLICY is not PASSIVE: training slows down several times when a core is busy; "
            "the tactogram command sets it, a script of your own must set it before importing torch"
        )
    if find_spec("torchvision") is not None:
        problems.extend(_vision_problem())
    if find_spec("torchaudio") is not None:
        problems.append(
            "torchaudio is installed: tactogram does not use it, and a mismatched one breaks imports"
        )
    return problems


def _vision_problem() -> list[str]:
    """Return the problems of an installed torchvision, imported through its guard."""
    from tactogram.nn.vision_import import vision_module

    try:
        extension = vision_module("torchvision.extension")
    except MissingExtraError as error:
        return [str(error)]
    if extension._has_ops():
        return []
    return [
        "torchvision's compiled operators do not load (its build is not that of torch): tactogram does without "
        "them, other programs may not; install the build of torchvision that matches torch"
    ]


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _memory_gib() -> float:
    if os.name == "nt":
        import psutil

        size = psutil.virtual_memory().total
    else:
        size = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return round(float(size) / 2**30, 1)
