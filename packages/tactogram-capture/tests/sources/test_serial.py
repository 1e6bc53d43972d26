"""The sketch in docs/boards.md: compiled for this computer, on a pseudo-terminal, read by the commands beside it."""

import os
import re
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram_capture import open_source
from tactogram_capture.stream import csv_source
from tactogram_capture.stream.byte_source import SerialPort

pytest.importorskip("serial")


tty = pytest.importorskip("tty")


DOCS = (Path(__file__).parents[4] / "docs/boards.md").read_text(encoding="utf-8")


[SKETCH] = re.findall(r"```cpp\n(.*?)```", DOCS, re.DOTALL)


HEADING = "t_us,ax_g,ay_g,az_g"


ARDUINO = r"""
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#define long int  // 32 bits, as on an Arduino
typedef uint8_t byte;
static unsigned long now_us;
static unsigned long micros() { return now_us += 4; }
struct {
  operator bool() { return true; }
  void begin(unsigned long baud) { if (baud != 115200) exit(3); }
  void print(char c) { putchar(c); }
  void print(int n) { printf("%d", n); }
  void print(unsigned long n) { printf("%u", n); }
  void print(double x, int decimals) { printf("%.*f", decimals, x); }
  void println(const char *text = "") { printf("%s\r\n", text); }
} Serial;
"""
"""Of the Arduino core, what the sketch uses."""


WIRE = r"""
struct {
  byte registers[128], at = 0, place = 0;
  bool addressed = false;
  int16_t sample[3];
  int count = 0;
  void begin() {}
  void setClock(unsigned long) {}
  void beginTransmission(byte address) { if (address != 0x68) exit(4); addressed = true; }
  void write(byte value) { if (addressed) at = value; else registers[at] = value; addressed = false; }
  void endTransmission(bool = true) {}
  void requestFrom(byte, byte bytes) {
    if (bytes != 6 || at != 0x3B || registers[0x6B] != 1 || registers[0x1C] != 0) exit(5);
    sample[0] = count * count * 37 % 8001 - 4000, sample[1] = -sample[0] / 2, sample[2] = 16384 + count % 2;
    ++count, place = 0;
  }
  byte read() { int16_t n = sample[place / 2]; return place++ % 2 ? n & 255 : n >> 8 & 255; }
} Wire;
"""
"""An MPU-6050 that counts."""


MAIN = r"""
int main(int, char **given) {
  now_us = strtoul(given[1], 0, 10);
  setvbuf(stdout, 0, _IOLBF, 0);
  for (setup();; loop()) if (Wire.count >= atoi(given[2])) return 0;
}
"""


@pytest.fixture(name="boards", scope="module")
def boards_fixture(tmp_path_factory):
    """Return the program of a board by whether it prints a heading."""
    if shutil.which("g++") is None:
        pytest.skip("needs g++")
    folder = tmp_path_factory.mktemp("board")
    (folder / "Wire.h").write_text(WIRE)
    for heading in ("true", "false"):
        sketch = SKETCH.replace("HEADING = true", f"HEADING = {heading}")
        (folder / f"{heading}.cpp").write_text(f"{ARDUINO}{sketch}{MAIN}")
        subprocess.run(
            ["g++", "-I", folder, "-o", folder / heading, folder / f"{heading}.cpp"],
            check=True,
            capture_output=True,
        )
    return {True: folder / "true", False: folder / "false"}


@pytest.fixture(name="port")
def port_fixture():
    """Return a handle at which a board prints, and the port at which it is read."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(master)
    os.close(slave)


@contextmanager
def reset_by_opening(board, master, *, start_us=0, rows=400):
    """Start a board whenever its port is opened, as an Arduino Uno does."""
    opened, processes = SerialPort.__enter__, []

    def enter(port):
        entered = opened(port)
        processes.append(subprocess.Popen([board, str(start_us), str(rows)], stdout=master))
        return entered

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(SerialPort, "__enter__", enter)
        patch.setattr(csv_source, "COMPARED_S", np.inf)  # it prints as quickly as it is read
        try:
            yield
        finally:
            for process in processes:
                process.kill()
                process.wait()


def recorded(address, board, master, *, rows=400, **how):
    """Return the samples and the source of a board that prints ``rows`` once its port is open."""
    blocks, count = [], 0
    with reset_by_opening(board, master, rows=rows, **how), open_source(address) as source:
        while count < rows - 1 and (block := source.read(10.0)) is not None:
            blocks.append(block.samples)
            count += len(block)
    return np.concatenate(blocks, axis=1), source


def counts(rows=400):
    x = np.arange(rows) ** 2 * 37 % 8001 - 4000
    return np.stack([x, -np.sign(x) * (abs(x) // 2), 16384 + np.arange(rows) % 2])


def test_docs_name_the_heading_the_port_and_the_remedy():
    assert f'if (HEADING) Serial.println("\\n{HEADING}");' in SKETCH
    assert "--source serial:/dev/ttyACM0 " in DOCS
    assert "--source 'serial:/dev/ttyACM0?unit=g/16384' " in DOCS


@pytest.mark.parametrize("start_us", [0, 2**32 - 800_000])
def test_sketch_with_heading_gives_x_y_z_in_its_unit(boards, port, start_us):
    samples, source = recorded(f"serial:{port[1]}", boards[True], port[0], start_us=start_us)

    assert (source.axes, source.unit) == (("x", "y", "z"), "m/s^2")
    assert samples == pytest.approx(counts()[:, : samples.shape[1]] / 16384 * 9.80665, abs=5e-4)
    assert source.rate == pytest.approx(250, rel=0.01)
    assert source.estimate().hz == pytest.approx(250, rel=1e-3)
    assert source.facts()["lost"] == source.facts()["time_went_back"] == 0
    assert source.notes == ("time from t_us", "x, y, z from ax_g, ay_g, az_g, unit m/s^2")


@pytest.mark.parametrize("start_us", [0, 2**32 - 60_000])
def test_sketch_without_heading_gives_counts_and_the_address_that_converts_them(boards, port, start_us):
    samples, source = recorded(f"serial:{port[1]}", boards[False], port[0], start_us=start_us)

    assert (source.axes, source.unit) == (("x", "y", "z"), "1")
    # The first line may be the half of one.
    assert samples.tolist() == counts()[:, 1 : samples.shape[1] + 1].tolist()
    assert source.estimate().hz == pytest.approx(250, rel=1e-3)
    assert source.notes[0] == "column 1 rises: taken for the time, in us: 250 Hz"
    assert source.notes[1] == "x, y, z from column 2, 3, 4, unit 1"
    address = re.search(r"read as counts;.*`'(.*)'`", source.notes[2])[1]
    assert address == f"serial:{port[1]}?unit=g/16384"

    samples, source = recorded(address, boards[False], port[0])
    assert source.unit == "m/s^2"
    assert samples == pytest.approx(counts()[:, 1 : samples.shape[1] + 1] / 16384 * 9.80665, rel=1e-6)


@pytest.mark.parametrize("heading", [True, False])
def test_session_says_and_stores_what_the_columns_are(boards, port, tmp_path, capsys, heading):
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'title = "felt"\nmaterials = ["felt"]\nspeeds_mm_s = [100]\nseconds = 1\ncountdown_s = 0\n'
    )
    store = tmp_path / "store"
    with reset_by_opening(boards[heading], port[0], rows=10**6):
        words = [
            "capture",
            str(plan),
            "--source",
            f"serial:{port[1]}",
            "--data",
            str(store),
            "--yes",
            "--silent",
        ]
        assert main(words) == 0
    said = capsys.readouterr().err
    [info] = open_store(store).index
    [(name, signal)] = open_store(store)[info.id].streams.items()

    assert (name, signal.unit) == (("acceleration", "m/s^2") if heading else ("signal", "1"))
    assert signal.axes == ("x", "y", "z")
    assert signal.rate == pytest.approx(250, rel=0.01)
    assert np.ptp(signal.samples[2]) == (pytest.approx(0, abs=2e-3) if heading else 1)
    assert any("read as counts" in line for line in info.history) is not heading
    assert all(f"note: {note}" in said for note in info.history[:2])

    log = str(tmp_path / "store.sessions/plan/raw-001.log")
    assert main(["capture-log", log]) == 0
    assert ("`--set unit=g/16384`" in capsys.readouterr().err) is not heading
    assert main(["capture-log", log, "--set", "unit=g/16384"]) == 0
    assert "x/y/z in m/s^2 at 250" in capsys.readouterr().out
