"""Responses: tables, formulas, inverses, files."""

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.displays.response import (
    FlatResponse,
    ResonatorResponse,
    ResponseSource,
    TabulatedResponse,
    inverse,
    read_response,
    write_response,
)

F = np.geomspace(10, 1000, 200)


def test_a_resonator_has_its_resonance_and_its_plateau():
    r = ResonatorResponse(kind="resonator", unit="m/s^2", gain=4, resonance_hz=65, q=2)
    assert abs(r.at(65.0)) == pytest.approx(8)
    assert abs(r.at(6500.0)) == pytest.approx(4, rel=1e-3)
    octaves = np.abs(r.at(np.array([1.0, 2.0])))
    assert 20 * np.log10(octaves[1] / octaves[0]) == pytest.approx(40 * np.log10(2), abs=0.01)


def test_a_table_goes_through_its_points_and_holds_its_ends():
    points = ((20.0, 1.0, 0.5), (100.0, 4.0, 0.0), (500.0, 2.0, -7.0))
    table = TabulatedResponse(kind="table", unit="m/s^2", points=points)
    for f, gain, phase in points:
        assert table.at(f) == pytest.approx(gain * np.exp(1j * phase))
    assert abs(table.at(5.0)) == pytest.approx(1)
    assert abs(table.at(900.0)) == pytest.approx(2)
    assert table.range == (20.0, 500.0)


def test_the_inverse_undoes_the_response_within_cap_and_band():
    r = ResonatorResponse(kind="resonator", unit="m/s^2", gain=4, resonance_hz=65, q=2)
    inv = inverse(r, F, (20, 800), cap_db=60)
    inside = (F > 24) & (F < 700)
    np.testing.assert_allclose((inv.gain * r.at(F))[inside], 1, atol=1e-9)
    assert not inv.gain[(F < 20) | (F > 800)].any()
    capped = inverse(r, F, (20, 800), cap_db=3)
    assert np.abs(capped.gain).max() <= 10 ** (3 / 20) / np.abs(r.at(F)).max() + 1e-12
    assert capped.capped.any()
    with pytest.raises(ParameterError, match="no frequency"):
        inverse(FlatResponse(kind="flat", unit="m", gain=1), F, (2000, 3000), cap_db=0)


def test_a_response_survives_its_file(tmp_path):
    r = ResonatorResponse(kind="resonator", unit="m/s^2", gain=4, resonance_hz=65, q=2)
    path = tmp_path / "r.csv"
    write_response(path, F, r.at(F), unit="m/s^2/V", coherence=np.ones(len(F)))
    table = TabulatedResponse(kind="table", unit="m/s^2", points=read_response(path))
    between = np.sqrt(F[1:] * F[:-1])
    np.testing.assert_allclose(table.at(between), r.at(between), rtol=2e-3)


def test_degrees_and_a_missing_phase_are_understood(tmp_path):
    path = tmp_path / "r.csv"
    path.write_text("# measured\nFrequency [Hz],gain,phase [deg]\n10,1,180\n20,2,90\n")
    assert read_response(path)[0] == pytest.approx((10, 1, np.pi))
    path.write_text("10,1\n20,2\n")
    assert read_response(path) == ((10.0, 1.0, 0.0), (20.0, 2.0, 0.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("time,volts\n1,2\n", "line 1: expected columns"),
        ("10,1,0\nx,2,0\n", "line 2: expected numbers"),
        ("10,1,0\n10,2,0\n", "rising frequencies"),
        ("10,1,0\n20,0,0\n", "gain > 0"),
        ("10,nan,0\n20,1,0\n", "expected"),
    ],
)
def test_a_bad_file_is_refused_with_its_place(tmp_path, text, message):
    path = tmp_path / "r.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=message):
        read_response(path)


def test_a_display_reads_its_response_from_beside_its_file(tmp_path):
    r = ResonatorResponse(kind="resonator", unit="m/s^2", gain=4, resonance_hz=65, q=2)
    write_response(tmp_path / "mine.csv", F, r.at(F), unit="m/s^2/V")
    text = (
        'name = "mine"\ntitle = "mine"\nfamily = "linear"\nrate = 4000\nchannels = ["a"]\nunit = "V"\nlimit = 2\n'
        '[response]\nkind = "table"\nunit = "m/s^2"\nfile = "mine.csv"\n'
    )
    (tmp_path / "mine.toml").write_text(text)
    display = open_display(tmp_path / "mine.toml")
    assert abs(display.response.at(65.0)) == pytest.approx(8, rel=1e-3)
    (tmp_path / "mine.csv").unlink()
    with pytest.raises(DataError, match="mine.csv"):
        open_display(tmp_path / "mine.toml")


def test_a_table_needs_a_curve():
    adapter = TypeAdapter(ResponseSource)
    for points in ([], [[10, 1, 0]], [[20, 1, 0], [10, 1, 0]]):
        with pytest.raises(ValidationError):
            adapter.validate_python({"kind": "table", "unit": "m", "points": points})
