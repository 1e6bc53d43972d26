"""Fixtures that the tests of several models use."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import reduce
from typing import Any

import pytest


@pytest.fixture
def double_precision(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Compute in float64, so that two forms of one update differ by their formulas alone.

    Adam divides a gradient by its size: in float32, rounding decides where a weight goes whose gradient is 0.
    """
    import torch

    before = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    monkeypatch.setattr(torch.Tensor, "float", torch.Tensor.double)
    yield
    torch.set_default_dtype(before)


@pytest.fixture
def paper_values() -> Callable[[str, Iterable[str]], dict[str, Any]]:
    """Return a function that reads the recipe ``paper`` of a model at dotted keys of its configuration."""
    from tactogram import models
    from tactogram.recipe import Recipe

    def read(name: str, keys: Iterable[str]) -> dict[str, Any]:
        facts = models.find(name)
        config = facts.config(Recipe.load(facts.recipe("paper")).config)
        return {key: reduce(getattr, key.split("."), config) for key in keys}

    return read
