import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import memorisation, nearness
from tactogram.evaluation.measures.spectra import without_drift


def test_nearness_is_that_of_plain_loops(texture):
    one, trained = texture(0, seconds=1), texture(1, seconds=2)
    got = nearness([one], [trained])
    x, y = (without_drift(s.samples.astype(float), 1000.0) for s in (one, trained))
    for number, start in enumerate((0, 250, 500)):
        piece = x[:, start : start + 500]
        best = 0.0
        for t in range(y.shape[1] - 500 + 1):
            stretch = y[:, t : t + 500]
            norm = np.sqrt((piece**2).sum() * (stretch**2).sum())
            best = max(best, abs((piece * stretch).sum()) / norm)
        assert got[number] == pytest.approx(best, abs=1e-4)
    assert len(got) == 3


@given(st.floats(0.01, 100), st.booleans(), st.integers(0, 1500))
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_copy_is_near_whatever_its_place_level_and_sign(texture, gain, mirrored, start):
    trained = [texture(0), texture(1)]
    piece = trained[1].cut(start, start + 1500)
    copy = piece.with_samples(piece.samples * gain * (-1 if mirrored else 1))
    assert nearness([copy], trained)[1:-1].min() > 0.98


def test_silence_is_near_to_nothing(texture):
    trained = texture(0)
    silent = trained.with_samples(np.zeros_like(trained.samples))
    assert (nearness([silent], [trained]) == 0).all()
    assert (nearness([trained], [silent]) == 0).all()


def test_a_memorised_piece_is_detected_and_new_draws_are_not(texture):
    trained = [texture(k) for k in range(6)]
    unseen = [texture(k) for k in range(10, 16)]
    made = [texture(k) for k in range(20, 26)]
    assert memorisation(made, trained, unseen).copied <= 0.05
    copied = made[0].samples.copy()
    copied[:, 1000:2500] = -0.3 * trained[4].samples[:, 2000:3500]
    caught = memorisation([made[0].with_samples(copied), *made[1:]], trained, unseen)
    assert caught.copied >= 4 / 90  # of 90 pieces at least 4 lie wholly in the copied 1.5 s
    assert memorisation(trained, trained, unseen).copied == 1
    assert caught.made == pytest.approx(caught.unseen, abs=0.05)


def test_a_narrow_band_does_not_pass_for_a_copy(texture):
    # Any two stretches of a near sine are alike: unseen recordings say how alike.
    def narrow(seed):
        t = np.arange(4000) / 1000
        phase = np.cumsum(np.random.default_rng(seed).standard_normal(4000)) * 0.02
        wave = np.sin(2 * np.pi * 100 * t + phase)
        return texture(seed, axes=1).with_samples(wave)

    got = memorisation(*([narrow(10 * s + k) for k in range(5)] for s in range(3)))
    assert got.made > 0.8
    assert got.copied < 0.15


def test_signals_shorter_than_a_piece_are_refused(texture):
    short = texture(0, seconds=0.3)
    with pytest.raises(ParameterError, match="signals must hold one of 0.5 s"):
        nearness([short], [texture(0)])
    with pytest.raises(ParameterError, match="trained must hold a signal of 0.5 s"):
        nearness([texture(0)], [short])
    with pytest.raises(ParameterError, match="at least two samples"):
        nearness([texture(0)], [texture(0)], seconds=0)
    assert len(nearness([short], [texture(0)], seconds=0.2)) == 2
