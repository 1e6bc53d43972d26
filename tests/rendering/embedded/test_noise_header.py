"""The C header of a texture: its samples, compiled, are the package's; its costs, counted, are those it states."""

import shutil
import subprocess
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.embedded.noise_header import DISCARDED, MEAN, SCALE, c_name, noise_header, one_axis
from tactogram.signal import Signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import NoiseProcess, parameters_of
from tactogram.signal.tones import Tones

SEED = 7
CLOSE = 1e-5
"""Largest difference, as a share of the largest sample."""
MAIN = r"""
#include <stdio.h>
#include "weave.h"
int main(void) {
  static weave_state state;
  float out[WEAVE_AXES * WEAVE_BLOCK];
  int k;
  weave_init(&state, 7u);
  fprintf(stderr, "%lu", (unsigned long)sizeof state);
  for (k = 0; k < BLOCKS; k++) {
    weave_block(&state, out);
    fwrite(out, sizeof out, 1, stdout);
  }
  return 0;
}
"""
COUNTER = r"""
#include <cmath>
#include <cstdint>
#include <cstdio>
static long multiplications, divisions, functions;
struct Real {
  double v;
  Real() = default;
  template <class T> constexpr Real(T x) : v((double)x) {}
  explicit operator int32_t() const { return (int32_t)v; }
};
static Real operator*(Real a, Real b) { multiplications++; return a.v * b.v; }
static Real operator/(Real a, Real b) { divisions++; return a.v / b.v; }
static Real operator+(Real a, Real b) { return a.v + b.v; }
static Real operator-(Real a, Real b) { return a.v - b.v; }
static Real &operator+=(Real &a, Real b) { a.v += b.v; return a; }
static bool operator<(Real a, Real b) { return a.v < b.v; }
static bool operator>(Real a, Real b) { return a.v > b.v; }
#define WEAVE_REAL Real
#define WEAVE_EXP(x) (functions++, Real(std::exp((x).v)))
#define WEAVE_SQRT(x) (functions++, Real(std::sqrt(Real(x).v)))
#define WEAVE_SIN(x) (functions++, Real(std::sin((x).v)))
#define WEAVE_COS(x) (functions++, Real(std::cos((x).v)))
#include "weave.h"
int main() {
  static weave_state state;
  Real out[WEAVE_AXES * WEAVE_BLOCK];
  weave_init(&state, 7u);
  for (int k = 0; k < 6; k++) {
    multiplications = divisions = functions = 0;
    weave_block(&state, out);
    std::printf("%ld %ld %ld\n", multiplications, divisions, functions);
  }
}
"""


class SmallRandom:
    """Stream ``stream`` of a seed, both 32 bits: ``a`` is the seed, ``b`` the stream, ``c`` 0, the counter 1.

    Normal numbers have no value beyond 3.46 standard deviations, and an excess kurtosis of -0.3.
    """

    def __init__(self, seed, stream):
        self._a, self._b, self._c, self._counter = seed & 0xFFFFFFFF, stream & 0xFFFFFFFF, 0, 1
        for _ in range(DISCARDED):
            self.word()

    def word(self):
        """Return the next 32 bits."""
        found = (self._a + self._b + self._counter) & 0xFFFFFFFF
        self._counter = (self._counter + 1) & 0xFFFFFFFF
        self._a = self._b ^ (self._b >> 9)
        self._b = (self._c + (self._c << 3)) & 0xFFFFFFFF
        self._c = (((self._c << 21) | (self._c >> 11)) + found) & 0xFFFFFFFF
        return found

    def normal(self):
        """Return the next number of mean 0 and variance 1."""
        first, second = self.word(), self.word()
        total = (first & 0xFFFF) + (first >> 16) + (second & 0xFFFF) + (second >> 16)
        return (total - MEAN) * SCALE

    def standard_normal(self, *, out):
        """Fill ``out`` in C order, as numpy's generators do."""
        out[...] = np.fromiter((self.normal() for _ in range(out.size)), np.float64, out.size).reshape(
            out.shape
        )
        return out


def header_samples(model, samples, *, seed):
    """The first samples of a header, in double precision, shape (axis, time)."""
    sources = tuple(SmallRandom(seed, stream) for stream in range(3))
    out = np.empty((len(model.axes), samples))
    NoiseProcess(len(model.axes), model.lags, model.rate, seed=sources).next(out, parameters_of(model))
    return out


@cache
def texture(rate=1000.0, lags=3):
    """Simulated: two axes of noise whose strength changes."""
    random = np.random.default_rng(0)
    time = np.arange(round(4 * rate)) / rate
    noise = random.standard_normal((2, len(time))) * np.exp(np.sin(2 * np.pi * 5 * time))
    noise[1] += 0.5 * noise[0]
    return fit_modulated_noise([Signal(noise.astype(np.float32), rate, "m/s^2", ("x", "z"))], lags=lags)


def with_tones(model):
    amplitude = np.random.default_rng(1).normal(size=(2, len(model.axes), 2))
    return replace(
        model, tones=Tones(np.array([47.3, 194.6]), amplitude, np.array([0.05, 0.02, 0.8, 0.1, 0.9]))
    )


MODELS = {
    "two axes": texture,
    "one axis": lambda: one_axis(texture(), "dft321"),
    "tones": lambda: with_tones(texture()),
    "broken rate": lambda: one_axis(texture(rate=4000 / 3), "z"),
}


@pytest.fixture(params=MODELS)
def model(request):
    return MODELS[request.param]()


def compiled(folder, model, source, compiler, *options):
    """Return the result of a program with the header."""
    found = shutil.which(compiler)
    if found is None:
        pytest.skip(f"the system has no compiler {compiler}")
    text, cost = noise_header(model, name="weave", facts=["Simulated."])
    (folder / "weave.h").write_text(text, encoding="utf-8")
    path = folder / ("main.cpp" if compiler == "c++" else "main.c")
    path.write_text(source, encoding="utf-8")
    subprocess.run([found, *options, "-O1", str(path), "-o", str(folder / "main"), "-lm"], check=True)
    return subprocess.run([str(folder / "main")], check=True, capture_output=True), cost


def test_samples_are_those_of_the_package(model, tmp_path):
    blocks = round(2.5 / 0.005)  # beyond 2 s, after which the places of frames have come again
    strict = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", f"-DBLOCKS={blocks}")
    result, cost = compiled(tmp_path, model, MAIN, "cc", *strict)
    axes, size = len(model.axes), round(0.005 * model.rate)
    got = np.frombuffer(result.stdout, np.float32).reshape(blocks, axes, size)
    got = got.transpose(1, 0, 2).reshape(axes, -1)
    expected = header_samples(model, blocks * size, seed=SEED)
    np.testing.assert_allclose(got, expected, rtol=0, atol=CLOSE * np.abs(expected).max())
    assert int(result.stderr) == cost.state_bytes
    assert got.std() == pytest.approx(np.sqrt(model.power.mean()), rel=0.2)


def test_stated_costs_are_those_counted(model, tmp_path):
    result, cost = compiled(tmp_path, model, COUNTER, "c++", "-Wno-class-memaccess")
    counted = sorted(tuple(map(int, line.split())) for line in result.stdout.decode().splitlines())
    stated = [(each.multiplications, each.divisions, each.functions) for each in (cost.usual, cost.dearest)]
    if len(model.tones.frequency):  # their frames, of six multiplications, begin in other blocks
        stated = [(stated[0][0] + 6, *stated[0][1:]), (stated[1][0] - 6, *stated[1][1:])]
    assert {counted[0], counted[-1]} == set(stated)
    text = (tmp_path / "weave.h").read_text(encoding="utf-8")
    assert f"{cost.usual.multiplications} multiplications" in text
    assert f"{cost.table_bytes} bytes of read-only memory; state: {cost.state_bytes} bytes" in text


def test_random_numbers_are_normal_and_streams_differ():
    streams = [SmallRandom(SEED, stream).standard_normal(out=np.empty(20_000)) for stream in range(2)]
    for numbers in streams:
        assert abs(numbers.mean()) < 0.03
        assert numbers.std() == pytest.approx(1, abs=0.02)
        assert np.mean(numbers**4) == pytest.approx(2.7, abs=0.1)  # of the sum of four uniform numbers
        assert abs(np.corrcoef(numbers[:-1], numbers[1:])[0, 1]) < 0.03
    assert abs(np.corrcoef(*streams)[0, 1]) < 0.03


def test_names_are_those_of_c():
    assert c_name("Sandpaper P80") == "sandpaper_p80"
    assert c_name("3D print") == "texture_3d_print"
    with pytest.raises(ParameterError, match="name must be a C identifier"):
        noise_header(MODELS["one axis"](), name="P80")
