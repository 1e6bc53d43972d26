"""Functions that write a folder refuse, before they begin, one that another process or thread writes."""

from contextvars import Context
from pathlib import Path

import pytest

from tactogram.datasets import create_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.store.writing import copy_store
from tactogram.errors import ParameterError
from tactogram.signal.io import write_signal
from tactogram.signal.io.atomic import sole_writer
from tactogram.workflows.data.convert import convert
from tactogram.workflows.data.stores import export_store, import_store
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.generation.many import generate_many
from tactogram.workflows.training.export import export
from tactogram.workflows.training.train import train
from tactogram_simulate.workflows.simulate import simulate_to_store

WRITERS = {
    "create": lambda run, store, sounds, out: create_store(out, [], name="n", licence="-"),
    "import a data set": lambda run, store, sounds, out: import_dataset("folder", sounds, out),
    "import": lambda run, store, sounds, out: import_store("folder", sounds, out),
    "simulate": lambda run, store, sounds, out: simulate_to_store("surfaces", out),
    "copy": lambda run, store, sounds, out: copy_store(store, out),
    "export": lambda run, store, sounds, out: export_store(store, out=out),
    "train": lambda run, store, sounds, out: train("replay", store, recipe="tiny", out=out),
    "crossval": lambda run, store, sounds, out: crossval("replay", store, folds=2, out=out),
    "generate": lambda run, store, sounds, out: generate_many(run.folder, sounds / "c.csv", out),
    "run": lambda run, store, sounds, out: export(run.folder, out=out, to="hub"),
    "convert": lambda run, store, sounds, out: convert(sounds, out, format="csv"),
}


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_what_another_writes_is_refused_and_nothing_is_left(write, run, store, texture, tmp_path):
    write_signal(tmp_path / "sounds" / "cork" / "1.wav", texture("cork", 1))
    out = tmp_path / "out"
    with sole_writer(out), pytest.raises(ParameterError, match="out: process .* writes it at present"):
        Context().run(write, run, store, tmp_path / "sounds", out)
    assert [*Path(tmp_path).iterdir()] == [tmp_path / "sounds"]
