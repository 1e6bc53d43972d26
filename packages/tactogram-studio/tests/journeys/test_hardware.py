"""A builder of hardware: from files of other programs to a voice coil, driver chips and a microcontroller."""

import csv
import shutil
import subprocess

import numpy as np
import pytest
import soundfile
from scipy.io import wavfile

HUM_HZ = 160
HEADING = "Time,Channel A,Channel B,Channel C\n(ms),(g),(g),(g)\n\n"
PRINTER = """
#include <stdio.h>
#include "hum.h"
int main(void) {
  static hum_state state;
  hum_real block[HUM_AXES * HUM_BLOCK];
  hum_init(&state, 1);
  for (int n = 0; n < 500; n++) {
    hum_block(&state, block);
    for (int i = 0; i < HUM_BLOCK; i++) printf("%g\\n", (double)block[i]);
  }
  return 0;
}
"""


def scope(file):
    """Write what an oscilloscope with a row of units writes: an accelerometer on a humming motor, with gravity."""
    t = np.arange(4000) / 2000
    noise = 0.02 * np.random.default_rng(0).standard_normal(4000)
    hum = 0.2 * np.sin(2 * np.pi * HUM_HZ * t) + noise
    rows = (f"{1000 * s:.4f},{x:.6f},{x / 2:.6f},{1 + x / 4:.6f}" for s, x in zip(t, hum, strict=True))
    file.write_text(HEADING + "\n".join(rows) + "\n", encoding="utf-8")


def knock(file):
    """Write a sound of integers, as audio editors do: a click that dies away in half a second."""
    t = np.arange(44_100) / 44_100
    wavfile.write(file, 44_100, np.int16(20_000 * np.exp(-8 * t) * np.sin(2 * np.pi * 175 * t)))


def strengths(file):
    """Return the numbers of the second column of a table."""
    with file.open(newline="", encoding="utf-8") as opened:
        rows = [row for row in csv.reader(opened) if row and row[0][:1].isdigit()]
    return np.array([float(row[1]) for row in rows])


def test_a_measurement_and_a_sound_become_drives_that_other_programs_read(tactogram, tmp_path, step):
    scope(tmp_path / "hum.csv")
    knock(tmp_path / "knock.wav")
    with step("what is read of the oscilloscope's table"):
        said = tactogram("convert --check hum.csv")
    assert "Channel A" in said
    with step("a measurement in g for a voice coil"):
        said = tactogram("render hum.csv --display voice-coil --level sensation --out hum.wav")
    assert "gravity" in said
    drive, rate = soundfile.read(tmp_path / "hum.wav")
    assert rate == 8000
    assert len(drive) / rate == pytest.approx(2, abs=0.05)
    assert 0.01 < np.abs(drive).max() <= 5  # V, its limit
    assert np.argmax(np.abs(np.fft.rfft(drive))) * rate / len(drive) == pytest.approx(HUM_HZ, abs=2)
    with step("a sound, which has no unit, for the same"):
        said = tactogram(
            "render knock.wav --display voice-coil --level sensation --out knock_v.wav", status=1
        )
        assert "gain=FACTOR or peak=SHARE" in said
        tactogram("render knock.wav --display voice-coil --level peak=0.5 --out knock_v.wav")
    drive, _ = soundfile.read(tmp_path / "knock_v.wav")
    assert np.abs(drive).max() == pytest.approx(2.5, rel=0.01)
    with step("for two driver chips"):
        for chip, rate in (("lra-drv2605", 500), ("erm-drv2605", 200)):
            tactogram(f"render knock.wav --display {chip} --level peak=0.8 --out {chip}.csv")
            values = strengths(tmp_path / f"{chip}.csv")
            assert len(values) == pytest.approx(rate, abs=rate / 20)
            assert np.array_equal(values, np.round(values))  # registers
            assert 60 < np.abs(values).max() <= 127
            assert np.abs(values[: rate // 10]).mean() > 4 * np.abs(values[-rate // 2 :]).mean()


def test_a_drive_is_tried_before_any_actuator_is_connected(tactogram, tmp_path, step):
    knock(tmp_path / "knock.wav")
    tactogram("render knock.wav --display voice-coil --level peak=0.5 --out drive.wav")
    tactogram("render knock.wav --display ultrasonic-envelope --level peak=0.5 --out envelope.wav")
    with step("played to nothing"):
        said = tactogram("play drive.wav --display voice-coil --device null")
        assert "simulated_device: True" in said
        assert "state: ended" in said
        assert "state: ended" in tactogram("play envelope.wav --display ultrasonic-envelope --device null")
    with step("refusals that say what to do"):
        for line, remedy in {
            "play drive.wav --display voice-coil": "--device audio",
            "play drive.wav --display voice-coil --device audio": "--full-scale",
            "play knock.wav --display voice-coil --device null": "render it for this display",
        }.items():
            said = tactogram(line, status=1)
            assert remedy in said
            assert len(said.splitlines()) == 1
    with step("streamed under a finger to a file"):
        said = tactogram(
            "stream knock.wav --speed 100 --display voice-coil --level peak=0.5 --backend file --seconds 1 "
            "--out live.wav --quiet"
        )
    assert "knock: 1 s to file" in said  # the hand is simulated, the sound is not
    assert soundfile.info(tmp_path / "live.wav").frames == pytest.approx(8000, abs=80)


def test_a_measurement_becomes_a_header_that_a_c_compiler_takes(tactogram, tmp_path, step):
    if (compiler := shutil.which("cc")) is None:
        pytest.skip("no C compiler")
    scope(tmp_path / "hum.csv")
    with step("one stroke to a texture"):
        tactogram("clone hum.csv --speed 100 --out runs/hum")
    with step("the texture to a header"):
        said = tactogram("run export runs/hum --out hum.h", status=1)
        assert "--to c" in said
        tactogram("run export runs/hum --to c --material hum --speed 100 --force 1 --out hum.h")
    (tmp_path / "main.c").write_text(PRINTER)
    with step("compiled and run"):
        subprocess.run([compiler, "-std=c99", "-Wall", "-Werror", "main.c", "-lm"], cwd=tmp_path, check=True)
        printed = subprocess.run([tmp_path / "a.out"], capture_output=True, text=True, check=True).stdout
    samples = np.array(printed.split(), float)
    frequencies = np.fft.rfftfreq(len(samples), 1 / 2500)
    power = np.abs(np.fft.rfft(samples)) ** 2
    assert abs(frequencies[np.argmax(power)] - HUM_HZ) < 20
    rms = 9.80665 * 0.2 * np.sqrt((1 + 1 / 4 + 1 / 16) / 2)  # of three axes in one
    assert rms / 2 < samples.std() < 2 * rms


def test_an_uploaded_measurement_is_fitted_and_its_drive_downloaded(page, saved, step, tmp_path):
    scope(tmp_path / "hum.csv")
    with step("the upload"):
        page.goto("/send")
        page.get_by_role("button", name="Upload a file").click()
        page.locator("input[type=file]").set_input_files(tmp_path / "hum.csv")
        page.get_by_label("The signal").get_by_role("heading", name="hum").wait_for()
    with step("fitted to a voice coil"):
        page.get_by_role("radio", name="Physical").click()
        page.get_by_role("button", name="Fit to the display").click()
        report = page.get_by_role("region", name="Fit report")
        report.get_by_text("gravity").first.wait_for()
    with step("tried with nothing connected"):
        playing = page.get_by_role("region", name="Play on a device")
        playing.get_by_role("button", name="Play").click()
        playing.get_by_text("of 2.0 s").wait_for()
        playing.get_by_role("button", name="Stop").click()
        playing.get_by_text("stopped after").wait_for()
    drive, rate = soundfile.read(saved(report.get_by_role("link", name="Drive as WAV")))
    assert rate == 8000
    assert len(drive) / rate == pytest.approx(2, abs=0.05)
    assert 0.01 < np.abs(drive).max() <= 5  # V
    assert np.argmax(np.abs(np.fft.rfft(drive))) * rate / len(drive) == pytest.approx(HUM_HZ, abs=2)
    with step("and to a driver chip"):
        page.get_by_role("combobox", name="Display").click()
        page.get_by_role("option", name="lra-drv2605").click()
        page.get_by_role("button", name="Fit to the display").click()
        report.get_by_text("Linear resonant actuator").first.wait_for()
        file = saved(report.get_by_role("link", name="CSV"))
    values = strengths(file)
    assert len(values) == pytest.approx(1000, abs=50)  # 2 s at 500 Hz
    assert 60 < np.abs(values).max() <= 127
