"""The Penn Haptic Texture Toolkit: files of its layout, written here from known filters."""

import numpy as np
import pytest
from scipy.signal import lfilter, welch

from tactogram.errors import DataError, ParameterError
from tactogram.signal.line_spectrum import line_spectrum_of_reflection, reflection_of_polynomial
from tactogram_benchmark.importers import hatt

POLES = np.poly([0.9 * np.exp(0.8j), 0.9 * np.exp(-0.8j), 0.6, -0.4, 0.2]).real
ZEROS = np.poly([0.7 * np.exp(2j), 0.7 * np.exp(-2j), -0.5]).real
GAIN = 3.0
SPEEDS, FORCES = (0.0, 100.0, 200.0), (0.0, 1.0, 2.5)
POINTS = [(v, f) for v in SPEEDS for f in FORCES]


def variance(speed, force):
    """Silent at rest and in the air, as in the toolkit."""
    return 1e-6 * speed * force


def values(name, numbers, indent=""):
    inner = "".join(f"<value>{x:.6f}</value>" for x in numbers)
    return f"{indent}<{name} type='array'>{inner}</{name}>\n"


def triangles():
    """Two per cell of the grid, models counted from 1."""
    cells = [(3 * i + j + 1, 3 * i + j + 2, 3 * i + j + 4, 3 * i + j + 5) for i in (0, 1) for j in (0, 1)]
    return [t for a, b, c, d in cells for t in ((a, b, c), (b, c, d))]


def xml(material="Cork", zeros=ZEROS, points=POINTS, tri=None, rate=1000):
    lines = [line_spectrum_of_reflection(reflection_of_polynomial(p)) for p in (POLES, zeros)]
    text = "<?xml version='1.0' encoding='utf-8'?>\n<modelSet texture='0'>\n"
    text += f"<material>{material}</material><AccelUnits>m/s^2</AccelUnits><SpeedUnits>mm/s</SpeedUnits>\n"
    text += f"<ForceUnits>N</ForceUnits><SampleRate>{rate}</SampleRate><mu>0.577575</mu>\n"
    text += f"<numMod>{len(points)}</numMod><maxSpeed>200.0</maxSpeed><maxForce>2.5</maxForce>\n"
    text += values("speedList", [v for v, _ in points]) + values("forceList", [f for _, f in points])
    text += "".join(values("tri", t) for t in (triangles() if tri is None else tri))
    text += f"<numARCoeff>{POLES.size - 1}</numARCoeff><numMACoeff>{zeros.size - 1}</numMACoeff>\n"
    for number, (v, f) in enumerate(points, start=1):
        text += f"<model><modNum>{number}</modNum>\n" + values("ARlsf", lines[0])
        text += values("MAlsf", lines[1]) + f"<gain>{GAIN}</gain>" if zeros.size > 1 else ""
        text += f"<var>{variance(v, f):.9f}</var><speedMod>{v}</speedMod><forceMod>{f}</forceMod></model>\n"
    return text + "</modelSet>\n"


def write(folder, name="Cork", text=None):
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"Models_{name}.xml"
    file.write_text(xml(name) if text is None else text, encoding="utf-8")
    return file


def spectrum_of_the_filter(zeros, frequencies, rate=1000):
    z = np.exp(-2j * np.pi * frequencies / rate)
    gain = GAIN if zeros.size > 1 else 1.0
    return np.abs(gain * np.polyval(zeros[::-1], z) / np.polyval(POLES[::-1], z)) ** 2 * 2 / rate


@pytest.mark.parametrize("zeros", [ZEROS, np.ones(1)], ids=["ARMA", "AR"])
def test_spectrum_and_level_are_those_of_the_file(tmp_path, zeros):
    surface = hatt.read_surface(write(tmp_path, text=xml(zeros=zeros)))
    frequencies = np.linspace(5, 495, 200)
    got = surface.textures.at(100, 1.0).power_spectrum(frequencies)[0]
    expected = spectrum_of_the_filter(zeros, frequencies) * variance(100, 1)
    np.testing.assert_allclose(10 * np.log10(got / expected), 0, atol=0.1)


def test_level_of_a_recording_is_that_of_scipys_filter(tmp_path):
    (item,) = hatt.find(write(tmp_path).parent)
    recording = next(r for r in hatt.read(item) if (r.speed_mm_s, r.force_n) == (100, 1))
    noise = np.random.default_rng(0).standard_normal(200_000) * np.sqrt(variance(100, 1))
    expected = lfilter(GAIN * ZEROS, POLES, noise)
    made = recording.stream("acceleration").samples[0]
    assert made.std() == pytest.approx(expected.std(), rel=0.05)
    f, got = welch(made, 1000, nperseg=256)
    _, wanted = welch(expected, 1000, nperseg=256)
    assert np.sqrt(np.mean((10 * np.log10(got / wanted)[(f > 5) & (f < 490)]) ** 2)) < 1


def test_power_between_models_is_linear_over_the_files_own_triangles(tmp_path):
    """On the diagonal of a cell only the triangles say which models are meant."""
    a = hatt.read_surface(write(tmp_path / "a")).textures
    other = [
        t
        for p, q, r, s in [(1, 2, 4, 5), (2, 3, 5, 6), (4, 5, 7, 8), (5, 6, 8, 9)]
        for t in ((p, q, s), (p, r, s))
    ]
    b = hatt.read_surface(write(tmp_path / "b", text=xml(tri=other))).textures
    one = a.at(100, 1).power[0]
    assert a.at(150, 0.5).power[0] / one == pytest.approx(
        0.5 * variance(200, 0) / variance(100, 1) + 0.5, rel=1e-3
    )
    assert b.at(150, 0.5).power[0] / one == pytest.approx(0.5 * variance(200, 1) / variance(100, 1), rel=1e-3)


def test_surface_fades_out_at_rest(tmp_path):
    textures = hatt.read_surface(write(tmp_path)).textures
    assert textures.at(0, 1).power[0] == 0
    assert textures.at(50, 1).power[0] == pytest.approx(textures.at(100, 1).power[0] / 2, rel=1e-3)


def test_recordings_say_what_they_are(tmp_path):
    write(tmp_path / "XML", "Dot Paper")
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "Dot Paper_square.bmp").write_bytes(b"BM")
    (item,) = hatt.find(tmp_path)
    recordings = hatt.read(item)

    assert item.image == tmp_path / "images" / "Dot Paper_square.bmp"
    assert item.name == "XML/Models_Dot Paper.xml"
    assert len(recordings) == 4 * 3
    assert len({r.id for r in recordings}) == 12
    for r in recordings:
        signal = r.stream("acceleration")
        assert (r.material, r.simulated, signal.unit, signal.rate) == ("Dot Paper", True, "m/s^2", 1000)
        assert signal.seconds == hatt.SECONDS
        assert "synthesised" in r.history[-1]
        assert r.labels["friction_coefficient"] == "0.577575"
        assert r.source.startswith(item.name)


def test_reading_again_is_the_same(tmp_path):
    (item,) = hatt.find(write(tmp_path).parent)
    assert [r.id for r in hatt.read(item)] == [r.id for r in hatt.read(item)]


def test_conditions_beyond_what_was_recorded_are_left_out(tmp_path):
    text = xml().replace("<maxForce>2.5<", "<maxForce>0.3<").replace("<maxSpeed>200.0<", "<maxSpeed>120.0<")
    (item,) = hatt.find(write(tmp_path, text=text).parent)
    assert {(r.speed_mm_s, r.force_n) for r in hatt.read(item)} == {(50, 0.3), (100, 0.3)}


def test_same_vertex_twice_is_met_once(tmp_path):
    surface = hatt.read_surface(write(tmp_path, text=xml(points=[*POINTS, POINTS[4]])))
    assert len(surface.textures.models) == 9


def broken(old, new):
    return xml().replace(old, new)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not readable as XML"),
        ("cork", "not readable as XML"),
        (xml()[:3000], "not readable as XML"),
        ("<html></html>", "expected <modelSet>"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><modelSet>&a;</modelSet>", "document type or entity"),
        (broken("<AccelUnits>m/s^2<", "<AccelUnits>g<"), "AccelUnits must be m/s"),
        (broken("<numMod>9<", "<numMod>10<"), "says 10 models, found 9"),
        (broken("<SampleRate>1000</SampleRate>", ""), "expected <SampleRate> in <modelSet>"),
        (broken("<SampleRate>1000<", "<SampleRate>fast<"), "SampleRate must be a number, got 'fast'"),
        (broken("<SampleRate>1000<", "<SampleRate>0<"), "SampleRate must be > 0 Hz"),
        (broken("<var>0.000100000<", "<var>nan<"), "model 5: var must be a finite"),
        (broken("<var>0.000100000<", "<var>-1<"), "model 5: var must be >= 0"),
        (xml(tri=[(1, 2, 10)]), "model numbers from 1 to 9"),
        (xml(tri=[(1, 2)]), "three model numbers"),
        (
            xml().replace("<ARlsf type='array'><value>", "<ARlsf type='array'><value>9</value><value>"),
            "ascend",
        ),
    ],
)
def test_broken_file_is_one_line_that_names_it(tmp_path, text, message):
    file = write(tmp_path, text=text)
    with pytest.raises(DataError, match=message) as error:
        hatt.read_surface(file)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_other_bytes_are_refused(tmp_path):
    file = tmp_path / "Models_Cork.xml"
    file.write_bytes(xml().encode("utf-16"))
    with pytest.raises(DataError, match="not UTF-8 text|not a text file"):
        hatt.read_surface(file)


def test_folder_without_models_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"must hold model files Models_NAME\.xml"):
        hatt.find(tmp_path)


def test_negative_speed_is_refused_by_the_map(tmp_path):
    with pytest.raises(ParameterError, match="speed_mm_s must be finite"):
        hatt.read_surface(write(tmp_path)).textures.at(-1, 1)
