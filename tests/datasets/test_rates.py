"""Rates of a store: one where they differ by jitter, several where sensors differ, and never a stated one changed."""

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.datasets.rates import CommonRates
from tactogram.datasets.recording import FileReading, Recording
from tactogram.signal import Signal
from tactogram.workflows.data.stores import add_signal


def recording(rate, *, estimated=True, seed=0):
    signal = Signal(np.random.default_rng(seed).standard_normal(2000), rate, "m/s^2")
    reading = FileReading((), False, None, estimated)
    return Recording(streams={"acceleration": signal}, reading=reading)


def write_table(path, rate, *, jitter=0.05, seed=0):
    rng = np.random.default_rng(seed)
    times = (np.arange(2000) + rng.uniform(-jitter, jitter, 2000)) / rate
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = "".join(f"{t:.6f},{x:.5f}\n" for t, x in zip(times, rng.standard_normal(2000), strict=True))
    path.write_text("time [s],x [g]\n" + rows)


def rates_of(store):
    return [store.rate(info.id, "acceleration") for info in store.index]


@pytest.mark.parametrize(
    ("estimated", "rate"), [(999.95, 1000), (330.02, 330), (99.634, 99.63), (1024.01, 1024)]
)
def test_the_first_estimate_is_rounded_within_its_accuracy(estimated, rate):
    first = recording(estimated)
    united = CommonRates().united(first)
    assert united.streams["acceleration"].rate == rate
    np.testing.assert_array_equal(
        united.streams["acceleration"].samples, first.streams["acceleration"].samples
    )
    assert united.history == (f"estimated rate of {estimated:g} Hz taken as {rate:g} Hz",)


def test_a_close_estimate_is_resampled_to_the_rate_before_it_and_it_is_said():
    rates = CommonRates({"acceleration": [100.0]})
    wave = Signal(np.sin(2 * np.pi * 5 * np.arange(2000) / 99), 99.0, "m/s^2")
    united = rates.united(
        Recording(streams={"acceleration": wave}, reading=FileReading((), False, None, True))
    )
    signal = united.streams["acceleration"]
    assert (signal.rate, united.history) == (
        100.0,
        ("resampled from 99 Hz to 100 Hz, the rate of other recordings",),
    )
    expected = np.sin(2 * np.pi * 5 * np.arange(len(signal)) / 100)
    np.testing.assert_allclose(signal.samples[0, 100:-100], expected[100:-100], atol=1e-3)
    assert united.id != recording(99.0).id


def test_stated_and_distant_rates_stay():
    rates = CommonRates()
    for rate, estimated in ((1000.0, False), (999.9, False), (1024.0, True), (500.0, True)):
        assert rates.united(recording(rate, estimated=estimated)).streams["acceleration"].rate == rate
    assert rates.several == {"acceleration": [500.0, 999.9, 1000.0, 1024.0]}


def test_jittered_tables_make_a_store_of_one_rate(tmp_path):
    for number, rate in enumerate((999.98, 1000, 1000.3, 1009)):
        write_table(tmp_path / "f" / "cork" / f"{number}.csv", rate, seed=number)
    report = import_dataset("folder", tmp_path / "f", tmp_path / "s", workers=1)
    store = open_store(tmp_path / "s")
    assert (rates_of(store), report["several_rates_hz"]) == ([1000.0] * 4, {})
    assert "resampled from 1009 Hz to 1000 Hz" in store.index[3].history[-1]
    assert import_dataset("folder", tmp_path / "f", tmp_path / "s", workers=1)["unchanged"]


def test_an_added_table_gets_the_rate_of_the_store(tmp_path):
    write_table(tmp_path / "f" / "cork" / "a.csv", 500)
    write_table(tmp_path / "b.csv", 499.96, seed=1)
    import_dataset("folder", tmp_path / "f", tmp_path / "s", workers=1)
    add_signal(tmp_path / "s", tmp_path / "b.csv", material="felt")
    assert rates_of(open_store(tmp_path / "s")) == [500.0, 500.0]


def test_different_rates_are_listed_with_what_to_do(tmp_path, capsys):
    write_table(tmp_path / "f" / "cork" / "a.csv", 500)
    write_table(tmp_path / "f" / "felt" / "b.csv", 1000, seed=1)
    words = ["data", "import", "folder", str(tmp_path / "f")]
    assert main([*words, "--out", str(tmp_path / "s")]) == 0
    line = "acceleration: 500, 1000 Hz; a training needs one rate: train … --set prepare.rate=500\n"
    assert line in capsys.readouterr().out
    assert main([*words, "--out", str(tmp_path / "one"), "--set", "rate=500"]) == 0
    assert rates_of(open_store(tmp_path / "one")) == [500.0, 500.0]
