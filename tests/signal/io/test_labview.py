"""LVM and TDMS files of LabVIEW."""

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from tests.signal.io.sample_files import WAVE, X, tdms

from tactogram.errors import DataError
from tactogram.signal.io import read_columns, read_file, read_signal
from tactogram.signal.io.content import TableLayout

HEAD = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t,
Multi_Headings\tNo
X_Columns\t{columns}
Time_Pref\tAbsolute
Date\t2026/05/04
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t40\t40\t
Y_Unit_Label\tVolts\tVolts\t
X_Dimension\tTime\tTime\t
X0\t0,0000000000000000E+0\t0,0000000000000000E+0\t
Delta_X\t{delta}\t{delta}\t
***End_of_Header***\t\t
"""


def written(
    tmp_path, columns="One", delta="5,000000E-4", heading="X_Value\tleft\tright\tComment", step=0.0005
):
    rows = [f"{step * k if columns == 'One' else ''}\t{x}\t{-x}\t" for k, x in enumerate(X)]
    if columns == "Multi":
        rows = [f"{step * k}\t{x}\t{step * k}\t{-x}\t" for k, x in enumerate(X)]
    text = HEAD.format(columns=columns, delta=delta) + "\n".join([heading, *rows]).replace(".", ",")
    (tmp_path / "a.lvm").write_text(text)
    return tmp_path / "a.lvm"


@pytest.mark.parametrize("columns", ["One", "No", "Multi"])
def test_lvm_with_any_time_columns(tmp_path, columns):
    heading = {"Multi": "X_Value\tleft\tX_Value\tright\tComment"}.get(
        columns, "X_Value\tleft\tright\tComment"
    )
    signal = read_signal(written(tmp_path, columns, heading=heading))
    assert (signal.rate, signal.unit, signal.axes) == (pytest.approx(2000, rel=1e-12), "V", ("left", "right"))
    np.testing.assert_allclose(signal.samples, [X, -X], atol=1e-6)


def test_time_stamps_of_an_lvm_decide_against_its_header(tmp_path):
    file = read_file(written(tmp_path, step=0.001))
    assert file.signal.rate == pytest.approx(1000)
    assert (file.columns[0].heading, file.columns[0].role) == ("X_Value [s]", "time")


def test_measurements_of_the_same_channels_are_parts_of_one_table(tmp_path):
    path = written(tmp_path)
    again = path.read_text().partition("***End_of_Header***\t\n")[2]
    path.write_text(path.read_text() + "\n\n" + again.replace("\t0,", "\t1,"))
    with pytest.raises(DataError, match="rows 58 to 69: time goes back by 0.0195 s.*`part=1`"):
        read_signal(path)
    assert len(read_signal(path, part=2)) == 40


def test_channels_of_an_lvm_without_times_may_have_rates_of_their_own(tmp_path):
    text = written(tmp_path, columns="No").read_text()
    text = text.replace("Delta_X\t5,000000E-4\t5", "Delta_X\t5,000000E-4\t1").replace(
        "Volts\tVolts", "Volts\tNewton"
    )
    (tmp_path / "a.lvm").write_text(text)
    file = read_file(tmp_path / "a.lvm")
    assert (file.stream, file.signal.rate, file.others["voltage"].rate) == ("force", 10000, 2000)


def test_an_lvm_with_a_layout(tmp_path):
    headings = ("X_Value [s]", "left [V]", "right [V]")
    assert tuple(use.heading for use in read_columns(written(tmp_path))) == headings
    layout = TableLayout(columns=headings, axes={"x": "right [V]"}, unit="g", time="X_Value [s]")
    signal = read_signal(tmp_path / "a.lvm", layouts=[layout])
    np.testing.assert_allclose(signal.samples, [-9.80665 * X], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda text: "LabView 7\n" + text, "must begin with 'LabVIEW Measurement', got 'LabView 7'"),
        (lambda text: text.partition("Channels")[0], "has no channels"),
        (lambda text: text.partition("\n0,0")[0], "no rows below the heading"),
        (
            lambda text: text.replace("\n0,001\t", "\n0,001\tx"),
            "row 21, column 'left .V.': expected a number, got 'x0.909",
        ),
        (lambda text: text + "\nChannels\t2\n***End_of_Header***\n", "row 59: no rows below this header"),
    ],
)
def test_a_bad_lvm_is_refused(tmp_path, change, says):
    path = written(tmp_path)
    path.write_text(change(path.read_text()))
    with pytest.raises(DataError, match=says):
        read_signal(path)


@pytest.mark.parametrize("head", ["X_Value\tbase\ttool\tComment\n", ""])
def test_an_lvm_without_headers_is_a_table(tmp_path, head):
    """LabVIEW writes no header where *Segment Headers* is *No headers*."""
    rows = [f"{i / 1000:.6f}\t{v:.6f}\t{2 * v:.6f}\n" for i, v in enumerate(WAVE)]
    (tmp_path / "a.lvm").write_text(head + "".join(rows))
    signal = read_signal(tmp_path / "a.lvm")
    assert (signal.rate, signal.axes) == (pytest.approx(1000), ("base", "tool") if head else ("1", "2"))
    np.testing.assert_allclose(signal.samples, [WAVE, 2 * WAVE], atol=1e-5)


def test_channels_of_tdms_have_rates_of_their_own(tmp_path):
    with TdmsWriter(tmp_path / "a.tdms") as file:
        fast = ChannelObject("A", "ai0", np.tile(WAVE, 5), {"wf_increment": 1e-4, "unit_string": "V"})
        file.write_segment(
            [fast, ChannelObject("A", "force", WAVE, {"wf_increment": 1e-3, "unit_string": "N"})]
        )
    file = read_file(tmp_path / "a.tdms")
    assert (file.stream, file.signal.rate, file.others["voltage"].rate) == (
        "force",
        pytest.approx(1000),
        pytest.approx(10000),
    )


def test_a_tdms_that_is_cut_off_is_read_and_said(tmp_path):
    tdms(tmp_path / "a.tdms")
    (tmp_path / "a.tdms").write_bytes((tmp_path / "a.tdms").read_bytes()[:-1000])
    assert "last segment is cut off: what is there is read" in read_file(tmp_path / "a.tdms").notes
