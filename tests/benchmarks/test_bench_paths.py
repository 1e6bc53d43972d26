"""The tracer of code paths: what it counts and what it leaves out."""

import importlib
import sys
import threading

import pytest
from benchmarks import bench_paths
from benchmarks.bench_paths import Trace, is_ours

OUTER = """
import json
import threading

def start():
    json.dumps({1: 2}, default=inner)  # frames of other libraries are not counted
    return sorted([inner(value) for value in values()], key=lambda value: -value)

def inner(value):
    return value + 1

def values():
    yield from (inner(1), 2)

def import_lazily():
    import tactogram_traced_inner
    return tactogram_traced_inner.late()

def recover():
    try:
        fail()
    except ValueError:
        return inner(0)

def fail():
    inner(0)
    raise ValueError

def in_thread():
    thread = threading.Thread(target=start)
    thread.start()
    thread.join()
"""
INNER = """
def early():
    return 1

VALUE = early()

def late():
    return VALUE
"""


@pytest.fixture(name="outer")
def outer_fixture(tmp_path, monkeypatch):
    """Give a module that counts as one of ours, and that has not imported the other one yet."""
    for name, text in {"tactogram_traced": OUTER, "tactogram_traced_inner": INNER}.items():
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield importlib.import_module("tactogram_traced")
    for name in ("tactogram_traced", "tactogram_traced_inner"):
        sys.modules.pop(name, None)


def names(trace):
    return sorted(code.co_name for code in trace.functions)


def test_functions_and_depth_are_counted_once_and_without_comprehensions(outer):
    with Trace() as trace:
        outer.start()
    assert names(trace) == ["<lambda>", "inner", "start", "values"]
    assert trace.deepest == [f"tactogram_traced.{name}" for name in ("start", "values", "inner")]
    assert trace.counts() == {"modules": 1, "functions": 4, "depth": 3}


def test_an_import_and_what_it_calls_are_not_counted(outer):
    with Trace() as trace:
        assert outer.import_lazily() == 1
    assert names(trace) == ["import_lazily", "late"]
    assert trace.modules == {"tactogram_traced", "tactogram_traced_inner"}


def test_an_exception_leaves_the_depth_right(outer):
    with Trace() as trace:
        outer.recover()
    assert len(trace.deepest) == 3
    with Trace() as trace:
        outer.inner(0)
    assert len(trace.deepest) == 1


def test_threads_are_counted_with_a_depth_of_their_own(outer):
    with Trace() as trace:
        outer.in_thread()
    assert names(trace) == ["<lambda>", "in_thread", "inner", "start", "values"]
    assert len(trace.deepest) == 3
    assert (sys.getprofile(), threading.getprofile()) == (None, None)


def test_the_applications_count_and_names_that_only_look_alike_do_not():
    assert all(is_ours(name) for name in ("tactogram", "tactogram.signal.io", "tactogram_study.designs"))
    assert not any(is_ours(name) for name in ("tactograms", "tactogramx.signal", "benchmarks.tactogram"))


def test_a_path_is_traced_from_the_command_line_and_from_python(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bench_paths._write_inputs(tmp_path)
    command, python = (
        bench_paths.trace_here(start, "photograph to file") for start in ("command line", "Python")
    )
    assert (tmp_path / "photo-1.ahap").read_bytes() == (tmp_path / "photo-2.ahap").read_bytes()
    assert "tactogram.cli" in {name.rpartition(".")[0] for name in command["module names"]}
    assert command["depth"] > python["depth"] > 3
    assert command["modules"] > python["modules"] > 5
