"""Headings of loggers and what they mean."""

import numpy as np
import pytest
from tests.signal.io.sample_files import X, written

from tactogram.signal.io import read_signal


def test_units_in_headings_are_brought_to_one(tmp_path):
    text = "t (ms);x (g);y [mg];z [m/s²]\n" + "\n".join(f"{i};1;1000;9.80665" for i in range(5))
    signal = read_signal(written(tmp_path, text))
    assert (signal.unit, signal.axes) == ("m/s^2", ("x", "y", "z"))
    np.testing.assert_allclose(signal.samples, 9.80665, rtol=1e-6)


LOGGERS = {
    "phyphox": (
        "Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2),Linear Acceleration z (m/s^2),"
        "Absolute acceleration (m/s^2)"
    ),
    "phyphox in German": "Zeit (s);Beschleunigung x (m/s²);Beschleunigung y (m/s²);Beschleunigung z (m/s²)",
    "Physics Toolbox": "time,ax (m/s^2),ay (m/s^2),az (m/s^2),aT (m/s^2)",
    "Physics Toolbox, in g": "time,gFx,gFy,gFz,TgF",
    "MetaMotion": "elapsed (s),x-axis (g),y-axis (g),z-axis (g)",
    "a logger": "Elapsed Time,X-Axis (g),Y-Axis (g),Z-Axis (g)",
    "milliseconds": "timestamp_ms,acc_x,acc_y,acc_z",
    "Sensor Logger": "time,seconds_elapsed,z,y,x",
    "Arduino": "millis,ax,ay,az",
}


@pytest.mark.parametrize("logger", LOGGERS)
def test_loggers_are_understood(logger, tmp_path):
    heading = LOGGERS[logger]
    separator = ";" if ";" in heading else ","
    ms = "_ms" in heading or "millis" in heading
    rows = []
    for k, value in enumerate(X):
        sides = [value, 2 * value, 3 * value, np.sqrt(14) * abs(value)]
        time = [1.7e18 + 1e7 * k, 0.01 * k] if "seconds_elapsed" in heading else [(10 if ms else 0.01) * k]
        count = heading.count(separator) + 1 - len(time)
        row = separator.join(f"{number:.9g}" for number in [*time, *sides[:count]])
        rows.append(row.replace(".", ",") if separator == ";" else row)
    text = "Logger X200\nSerial: 1234\n\n" * (logger == "a logger") + "\n".join([heading, *rows])
    signal = read_signal(written(tmp_path, text), unit=None if "(m/s" in heading or "(g)" in heading else "g")
    assert (signal.rate, signal.unit, signal.axes) == (pytest.approx(100), "m/s^2", ("x", "y", "z"))
    gravity = 1.0 if "(m/s" in heading else 9.80665
    sides = [3, 2, 1] if logger == "Sensor Logger" else [1, 2, 3]
    np.testing.assert_allclose(signal.samples, gravity * np.outer(sides, X), rtol=1e-6, atol=1e-6)
