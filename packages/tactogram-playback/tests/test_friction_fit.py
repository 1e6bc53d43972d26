import numpy as np
import pytest
import statsmodels.api as sm

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.drive.electrovibration import Settings, friction
from tactogram.rendering.drive.friction_calibration import read_calibrations
from tactogram_playback.friction_fit import FrictionMeasurements, calibrated, read_pairs, write_calibrations


def simulated_pairs(k_e=2e-5, *, seed=0, noise=0.01, repeats=8, person="p1", exponent=2.0, force=0.5):
    v = np.repeat([0, 40, 60, 80, 100.0], repeats)
    mu = 0.3 * (1 + k_e * v**exponent * 100 ** (2 - exponent) / force)
    wrong = noise * np.random.default_rng(seed).standard_normal(len(v))
    return FrictionMeasurements(person, v, mu + wrong, np.full(len(v), force))


def test_pairs_without_noise_give_their_constants_back():
    """Cai et al. 2020, Sec. 5: a regression "between the driven voltages and the frictional coefficients"."""
    found = calibrated(simulated_pairs(noise=0))
    assert (found.mu_0, found.newton_per_v2) == (pytest.approx(0.3), pytest.approx(2e-5))
    assert found.exponent == pytest.approx(2, abs=1e-4)
    assert found.r_squared == pytest.approx(1)


def test_the_line_is_that_of_ordinary_least_squares():
    pairs = simulated_pairs()
    u = pairs.voltage_v_rms**2 / pairs.normal_force_n
    theirs = sm.OLS(pairs.friction, sm.add_constant(u)).fit()
    ours = calibrated(pairs)
    np.testing.assert_allclose((ours.mu_0, ours.newton_per_v2 * ours.mu_0), theirs.params, rtol=1e-9)
    np.testing.assert_allclose(ours.mu_0_interval, theirs.conf_int()[0], rtol=1e-9)
    assert ours.residual_sd == pytest.approx(np.sqrt(theirs.scale))


def test_the_interval_of_k_e_holds_the_truth_as_often_as_it_says():
    within = 0
    for seed in range(400):
        low, high = calibrated(simulated_pairs(seed=seed), confidence=0.9).newton_per_v2_interval
        within += low <= 2e-5 <= high
    # 400 draws of 0.9: two standard errors are 0.03.
    assert within / 400 == pytest.approx(0.9, abs=0.035)


def test_another_law_than_the_square_is_seen():
    assert calibrated(simulated_pairs(noise=0.003)).square_law_holds is True
    assert calibrated(simulated_pairs(noise=0.003, exponent=1.2)).square_law_holds is False


def test_the_force_of_each_pair_counts():
    v = np.tile([0, 50, 100.0], 6)
    force = np.repeat([0.2, 0.5, 1.0], 6)
    found = calibrated(FrictionMeasurements("p", v, 0.3 * (1 + 2e-5 * v**2 / force), force))
    assert found.newton_per_v2 == pytest.approx(2e-5)
    assert found.normal_force_n == pytest.approx(force.mean())


@pytest.mark.parametrize(
    ("pairs", "match"),
    [
        (
            FrictionMeasurements("a", np.array([0, 50, 100.0]), np.array([0.3, 0.35, 0.4]), np.ones(3)),
            "needs 6 pairs",
        ),
        (
            FrictionMeasurements("a", np.tile([0, 100.0], 5), np.linspace(0.3, 0.4, 10), np.ones(10)),
            "10 at 2",
        ),
        (simulated_pairs(k_e=0.0), "does not rise"),
        (simulated_pairs(k_e=-2e-6), "does not rise"),
    ],
)
def test_pairs_that_say_nothing_are_refused(pairs, match):
    with pytest.raises(ParameterError, match=match):
        calibrated(pairs)


CSV = "person,voltage_v_rms,friction,normal_force_n\n"


def write_csv(path, *all_pairs):
    lines = [
        f"{p.person},{v},{mu},{force}"
        for p in all_pairs
        for v, mu, force in zip(p.voltage_v_rms, p.friction, p.normal_force_n, strict=True)
    ]
    path.write_text(CSV + "\n".join(lines) + "\n")
    return path


def test_people_are_told_apart_from_csv_to_toml_to_settings(tmp_path):
    table = write_csv(
        tmp_path / "pairs.csv",
        simulated_pairs(person="anna", seed=1),
        simulated_pairs(4e-5, person="ben", seed=2),
    )
    made = [calibrated(pairs) for pairs in read_pairs(table)]
    back = read_calibrations(write_calibrations(tmp_path / "calibration.toml", made))
    assert back == made
    assert [one.person for one in back] == ["anna", "ben"]
    assert back[1].newton_per_v2 / back[0].newton_per_v2 == pytest.approx(2, rel=0.2)
    settings = Settings(v_max=141, **back[0].settings())
    assert friction(100, settings) == pytest.approx(0.42, abs=0.02)
    assert "40 pairs of anna" in settings.calibrated_by


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("voltage_v_rms\n0\n", "lacks friction"),
        ("voltage_v_rms,friction\n0,0.3\n", "no column normal_force_n"),
        ("voltage_v_rms,friction,normal_force_n\n0,a,1\n", "line 2: needs numbers"),
        ("voltage_v_rms,friction,normal_force_n\n-1,0.3,1\n", "line 2: voltage must be >= 0"),
        ("voltage_v_rms,friction,normal_force_n\n1,0.3,0\n", "normal force > 0"),
        ("voltage_v_rms,friction,normal_force_n\n1e300,0.3,1\n", "each 0 or 1e-09 to 1e\\+09 in size"),
        ("voltage_v_rms,friction,normal_force_n\n1,0.3,1e-320\n", "each 0 or 1e-09 to 1e\\+09 in size"),
        ("voltage_v_rms,friction,normal_force_n\n1,nan,1\n", "each 0 or"),
        ("voltage_v_rms,friction,normal_force_n,x\n1,0.3,1,1\n", "unknown column 'x'"),
        ("voltage_v_rms,friction,normal_force_n\n", "no measurements"),
    ],
)
def test_a_bad_table_is_refused_with_its_place(tmp_path, text, match):
    path = tmp_path / "pairs.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=match):
        read_pairs(path)


def test_a_table_without_people_and_force_is_one_person_at_the_force_said(tmp_path):
    path = tmp_path / "pairs.csv"
    path.write_text("voltage_v_rms,friction\n0,0.3\n50,0.35\n")
    (pairs,) = read_pairs(path, normal_force_n=0.4)
    assert pairs.person == "all"
    assert pairs.normal_force_n.tolist() == [0.4, 0.4]
