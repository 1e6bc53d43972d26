"""Serial ports."""

import os

import pytest

from tactogram.errors import DeviceError
from tactogram_capture.stream.byte_source import SerialPort


@pytest.fixture(name="pty")
def pty_fixture():
    """Give a function that prints at a pseudo-terminal, its path, and one that unplugs it."""
    tty = pytest.importorskip("tty")
    ends = os.openpty()
    tty.setraw(ends[1])
    handles = [*ends]

    def unplug():
        while handles:
            os.close(handles.pop())

    yield lambda data: os.write(ends[0], data), os.ttyname(ends[1]), unplug
    unplug()


def test_a_missing_port_is_reported_in_one_line():
    with pytest.raises(DeviceError, match="/dev/tactogram-none") as caught, SerialPort("/dev/tactogram-none"):
        pass
    assert "\n" not in str(caught.value)


def test_a_port_that_another_program_reads_is_refused(pty):
    write, path, _ = pty
    with SerialPort(path) as port:
        with pytest.raises(DeviceError, match="exclusively lock"), SerialPort(path):
            pass
        write(b"1")
        assert port.read(1.0) is not None


def test_a_port_may_be_a_url_of_pyserial():
    with SerialPort("loop://") as port:
        port._port.write(b"12")
        data, _ = port.read(1.0)
        assert data in (b"1", b"12")
