import math

import pytest


@pytest.fixture(autouse=True)
def _read_in_this_process(monkeypatch):
    """Import in this process unless a test asks for several: on a busy machine even a few files take seconds."""
    monkeypatch.setattr("tactogram.datasets.reading.PATIENCE_S", math.inf)
