"""Surfaces predicted from photographs, names and words of simulated materials, where these tell the touch and not."""

from importlib.util import find_spec

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.signal import lfilter

from tactogram.errors import MissingExtraError, ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.texture_flow import Config, build, described_surfaces
from tactogram.models.texture_flow.described_surfaces import (
    DescribedSurfaces,
    _chosen,
    _spectrum,
    _weights,
    word_weights,
)
from tactogram.models.texture_flow.surfaces import SurfaceSpectra
from tactogram.signal import Image, Signal
from tactogram.training.loop import fit

RATE = 1000.0
CONFIG = Config(
    widths=(8, 16), embedding=16, frames=8, batch_size=2, steps=1, solver_steps=1, iterations=2, window_s=0.05
)
GRAINS = np.linspace(0.5, 4.0, 16)
"""Of 16 simulated materials, pixels: the coarser one looks, the louder and the lower it feels."""
NAMES = (
    "granite", "limestone", "marble", "sandstone", "slate", "basalt", "quartzite", "travertine",
    "silk", "velvet", "cotton fabric", "linen cloth", "wool fabric", "satin", "cashmere", "chiffon fabric",
)  # fmt: skip
HUES = (1.9, 1.0, 0.4), (0.4, 1.6, 0.6), (0.4, 0.8, 1.9), (1.0, 1.0, 1.0)
needs_text = pytest.mark.skipif(find_spec("wordllama") is None, reason="needs the extra text")
NOTHING = np.zeros((16, 0)), np.zeros(0)


def photograph(grain, seed, size=64):
    """Simulated: noise as coarse as ``grain``."""
    noise = gaussian_filter(np.random.default_rng(seed).standard_normal((size, size)), grain)
    grey = np.clip(0.5 + 0.12 * noise / noise.std(), 0, 1)
    return Image(np.uint8(255 * np.repeat(grey[..., None], 3, axis=2)))


def touch(grain, seed):
    """Simulated: noise through a low pass, 0.05 to 1 m/s^2."""
    noise = np.random.default_rng(seed).standard_normal(2000)
    x = lfilter([1], [1, -0.2 * grain], noise)
    return Signal(0.03 * 2.4**grain * x[None] / x.std(), RATE, "m/s^2", ("z",))


def surface(grain, seed):
    return SurfaceSpectra(CONFIG, RATE).measure([touch(grain, seed)])


def library(names=NAMES, felt=GRAINS, photographs=None):
    """Simulated materials that look as coarse as `GRAINS`, and feel as ``felt``."""
    known = DescribedSurfaces(names)
    if photographs is None:
        photographs = [photograph(grain, 50 + k) for k, grain in enumerate(GRAINS)]
    known.fit([surface(grain, k) for k, grain in enumerate(felt)], [[image] for image in photographs])
    return known


def shuffled():
    return GRAINS[np.random.default_rng(3).permutation(16)]


def off(known, prediction, grain):
    """Return how far the spectrum is from that of an unseen surface, and that of the mean is, dB rms."""
    truth = _spectrum(surface(grain, 999))
    spectra = prediction[0] @ known.spectra, known.spectra.mean(0)
    return [float(np.sqrt(np.mean((each - truth) ** 2))) for each in spectra]


@pytest.mark.parametrize("grain", [0.9, 1.3, 3.6])
def test_a_photograph_that_tells_the_touch_predicts_that_of_an_unknown_material(grain):
    known = library()
    prediction = known.predict(photograph(grain, 999), None, *NOTHING)
    error, of_mean = off(known, prediction, grain)
    assert error < 0.5 * of_mean
    assert prediction[0].sum() == pytest.approx(1)
    assert prediction[1]["given"] == ["image"]
    assert (prediction[1]["materials"], prediction[1]["mean"]) == (16, False)
    low, high = prediction[1]["explained_range"]
    assert 0 < low < prediction[1]["explained"] < high
    assert prediction[1]["explained"] > 0.6
    assert 0.3 < prediction[1]["error_db"] < np.std(known.spectra, axis=0).mean()


def test_photographs_that_tell_nothing_give_the_mean_and_it_is_said():
    known = library(felt=shuffled())
    prediction = known.predict(photograph(9.0, 999), None, *NOTHING)
    assert prediction[1]["mean"] is True
    assert prediction[1]["explained_range"][0] <= 0
    likely = known.recognised(photograph(9.0, 999))
    assert likely.sum() < 0.1
    np.testing.assert_allclose(prediction[0], likely + (1 - likely.sum()) / 16)


@needs_text
def test_few_materials_give_the_mean_and_no_figures():
    known = library()
    few = DescribedSurfaces(NAMES[:9])
    few.load_state(known.state() | {"spectra": known.spectra[:9], "shown": np.zeros(0, np.int64)})
    prediction = few.predict(None, "coarse stone", np.zeros((9, 0)), np.zeros(0))
    np.testing.assert_allclose(prediction[0], 1 / 9)
    assert prediction[1] == {"given": ["text"], "materials": 9, "mean": True, "unlike": False}


@needs_text
def test_a_name_that_tells_the_touch_predicts_that_of_an_unknown_material():
    known = library(felt=np.r_[np.linspace(3, 4, 8), np.linspace(1, 2, 8)])
    stone, cloth = (known.predict(None, text, *NOTHING) for text in ("flint stone", "denim fabric"))
    assert stone[1]["mean"] is False
    levels = [(each[0] @ known.spectra).mean() for each in (stone, cloth)]
    assert levels[1] + 2 < known.spectra.mean() < levels[0] - 2


@needs_text
def test_photograph_name_and_words_are_used_together_and_what_tells_nothing_is_not():
    rng = np.random.default_rng(0)
    known = library(names=[NAMES[k] for k in rng.permutation(16)])
    rated = np.column_stack((GRAINS / 4, rng.random(16)))
    rated[3, 0] = np.nan
    both = known.predict(photograph(3.6, 999), "chalk", rated, np.array([0.9, np.nan]))
    assert both[1]["given"] == ["image", "text", "words"]
    assert both[1]["materials"] == 15
    error, of_mean = off(known, both, 3.6)
    assert error < 0.5 * of_mean
    assert both[1]["explained"] > 0.6


def test_a_photograph_of_a_known_material_gives_that_material_though_photographs_explain_nothing():
    looks = [(grain, np.array(hue)) for grain in (0.6, 1.5, 3, 6) for hue in HUES]
    shown = [Image(np.uint8(photograph(grain, k, 224).pixels * hue)) for k, (grain, hue) in enumerate(looks)]
    known = library(felt=shuffled(), photographs=shown)
    again = Image(np.uint8(photograph(looks[11][0], 99, 224).pixels * looks[11][1]))
    prediction = known.predict(again, None, *NOTHING)
    assert prediction[1]["mean"] is True
    assert prediction[0][11] > 0.5
    board = np.kron(np.indices((14, 14)).sum(0) % 2, np.ones((16, 16)))[..., None] * (255, 255, 255)
    assert known.recognised(Image(board.astype(np.uint8))).sum() < 0.5


def test_a_photograph_that_two_materials_share_counts_once():
    photographs = [photograph(grain, 50 + k) for k, grain in enumerate(GRAINS)]
    known = library(photographs=[photographs[1], *photographs[1:]])
    prediction = known.predict(photographs[1], None, *NOTHING)
    assert known.recognised(photographs[1]).sum() == prediction[0].sum() == pytest.approx(1)


def test_without_the_extra_photographs_are_described_without_a_network(monkeypatch):
    def missing():
        raise MissingExtraError("pip install 'tactogram[vision]'")

    monkeypatch.setattr(described_surfaces, "_trunk", missing)
    known = library()
    assert known.photographs.shape == (16, 27)
    prediction = known.predict(photograph(3.6, 999), None, *NOTHING)
    error, of_mean = off(known, prediction, 3.6)
    assert error < 0.5 * of_mean


def test_the_errors_of_materials_left_out_are_those_of_as_many_fits():
    rng = np.random.default_rng(0)
    points, spectra = rng.standard_normal((12, 3)), rng.standard_normal((12, 4))
    kernels = [np.exp(-np.square(points[:, None] - points).sum(2) / width) for width in (0.5, 2.0, 8.0)]
    errors = {}
    for number, kernel in enumerate(kernels):
        for ridge in described_surfaces.RIDGES:
            residuals = []
            for out in range(12):
                rest = np.delete(np.arange(12), out)
                weights = _weights(kernel[np.ix_(rest, rest)], kernel[rest, out][:, None], ridge)
                assert weights.sum() == pytest.approx(1)
                residuals.append(spectra[out] - (weights @ spectra[rest])[0])
            errors[number, ridge] = np.square(residuals).sum()
    kernel, ridge = _chosen(kernels, spectra, np.arange(12))
    (number,) = [k for k, each in enumerate(kernels) if each is kernel]
    assert (number, ridge) == min(errors, key=errors.get)


@needs_text
def test_a_trained_model_generates_from_photograph_and_text_and_keeps_what_it_learned():
    kind = SignalKind(RATE, "m/s^2", ("z",), NAMES[::-1], simulated=True)
    examples = [
        Example(f"{name}-{turn}", touch(grain, 10 * k + turn), name, {}, [photograph(grain, k)])
        for k, (name, grain) in enumerate(zip(kind.materials, GRAINS, strict=True))
        for turn in range(2)
    ]
    learner = build(CONFIG, kind, seed=0)
    fit(learner, examples, seed=0)
    again = build(CONFIG, kind, seed=1)
    again.load_state(learner.state())
    coarse = {"image": photograph(3.7, 999), "text": "rough flint"}
    assert again.prediction_facts(coarse)["given"] == ["image", "text"]
    assert again.prediction_facts({"material": "silk"}) == {}
    loud, quiet = (
        again.generate(condition, seconds=2, seed=0).samples.std()
        for condition in (coarse, {"image": photograph(0.8, 999), "text": "thin fabric"})
    )
    assert loud > 4 * quiet
    assert loud == pytest.approx(touch(3.7, 5).samples.std(), rel=0.6)
    for twofold in ({"material": "silk", "text": "silk"}, {"vibration": touch(1.0, 0), "text": "silk"}):
        with pytest.raises(ParameterError, match="text.* describe the surface twice"):
            again.generate(twofold, seed=0)
    assert np.isfinite(again.generate({"text": "gravel"}, seed=0).samples).all()


RATED = np.array([[0.1, 0.5], [0.2, 0.5], [0.4, 0.5], [0.9, 0.5]])
"""Nearest neighbours are 0.1, 0.1, 0.2 and 0.5 apart: 0.15 by the median, half of which is the kernel's width."""


def test_weights_are_a_gaussian_of_the_distance_to_the_scores_asked():
    weights = word_weights(RATED, np.array([0.3, 0.5]))
    expected = np.exp(-(np.array([0.2, 0.1, 0.1, 0.6]) ** 2) / (2 * 0.075**2))
    np.testing.assert_allclose(weights, expected / expected.sum())


def test_beyond_all_rated_surfaces_it_is_the_nearest():
    np.testing.assert_allclose(word_weights(RATED, np.array([1.0, 0.5])), [0, 0, 0, 1], atol=1e-3)


def test_words_that_are_not_asked_do_not_count():
    weights = word_weights(RATED, np.array([0.3, np.nan]))
    np.testing.assert_allclose(weights, word_weights(RATED[:, :1], np.array([0.3])))


def test_a_surface_that_lacks_a_word_asked_weighs_nothing():
    rated = np.vstack((RATED, [[0.3, np.nan]]))
    scores = np.array([0.3, 0.5])
    np.testing.assert_allclose(word_weights(rated, scores), [*word_weights(RATED, scores), 0])
    assert word_weights(rated, np.array([0.3, np.nan])).argmax() == 4


def test_one_surface_and_equal_ones_are_all_there_is():
    for count in (1, 3):
        weights = word_weights(np.full((count, 2), 0.4), np.array([0.3, 0.5]))
        np.testing.assert_allclose(weights, 1 / count)


def test_no_score_and_no_rated_surface_are_refused():
    for rated, scores in ((RATED, RATED[0] * np.nan), (RATED * np.nan, RATED[0])):
        with pytest.raises(ParameterError, match="at least one that a surface was rated in"):
            word_weights(rated, scores)
