import multiprocessing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import welch
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram.datasets.simulate import make, simulate, simulated_sets, tasks
from tactogram.datasets.simulate.contact import FINGER, PEN, drag, feel
from tactogram.datasets.simulate.materials import STROKING_9, STROKING_30
from tactogram.datasets.simulate.photo import photograph
from tactogram.datasets.simulate.sensor import GRAVITY, sense, wired, wireless
from tactogram.datasets.simulate.stroke import LENGTH_MM, Stroke, stroke
from tactogram.datasets.simulate.surfaces import PATCH_MM, Grating, Roughness, Surface, height_field
from tactogram.errors import ParameterError

RATE = 8000.0


def steady(speed, seconds=2.0, force=0.7):
    n = int(seconds * RATE)
    return Stroke(RATE, np.arange(n) * speed / RATE, np.full(n, float(speed)), np.full(n, force))


@settings(deadline=None, max_examples=15)
@given(st.sampled_from([1.0, 1.6, 2.4, 4.0]), st.floats(40, 300), st.sampled_from([FINGER, PEN]))
def test_spatial_frequency_times_speed_is_what_is_felt(period, speed, contactor):
    ridges = Surface(f"ridges-{period}", (Grating(period, 0.02),), 0.4, 1.0)
    felt = feel(ridges, contactor, steady(speed), start_mm=(0, 0), direction_deg=0)
    f, power = welch(felt.normal[2000:], RATE, nperseg=len(felt.normal) - 2000)
    expected = speed * round(PATCH_MM / period) / PATCH_MM
    assert f[np.argmax(power)] == pytest.approx(expected, abs=1.5 * f[1])


@pytest.mark.parametrize("contactor", [FINGER, PEN])
def test_vibration_grows_with_speed(contactor):
    rough = Surface("rough", (Roughness(0.01, 2.0, 0.2, 4),), 0.4, 1.0)
    level = [
        feel(rough, contactor, steady(speed), start_mm=(0, 0), direction_deg=10).normal[2000:].std()
        for speed in (50, 100, 200, 400)
    ]
    assert np.all(np.diff(np.log(level)) > 0.2)


def test_a_faster_stroke_is_the_same_texture_shifted_up():
    rough = Surface("rough", (Roughness(0.01, 2.0, 0.2, 4),), 0.4, 1.0)
    centroids = []
    for speed in (60, 120):
        f, power = welch(
            feel(rough, FINGER, steady(speed, 4), start_mm=(0, 0), direction_deg=10).normal,
            RATE,
            nperseg=4096,
        )
        centroids.append((f * power).sum() / power.sum())
    assert centroids[1] / centroids[0] == pytest.approx(2, rel=0.25)


def slides(speed):
    """LuGre's canonical friction with a finger-like mass: the parameters of a published check."""
    n, dt = 60_000, 1 / 60_000
    hand = np.full(n, speed)
    force = np.full(n, 0.5)
    acceleration, friction = drag(
        hand, force, np.zeros(n), dt, 1e-3, 1000.0, 0.05, 0.5, 0.9, 0.010, 1e5, np.sqrt(1e5), 0.4
    )
    return acceleration[n // 2 :], friction[n // 2 :]


def test_it_sticks_and_slips_when_slow_and_slides_when_fast():
    for speed, sticks in ((0.010, True), (0.200, False)):
        acceleration, friction = slides(speed)
        assert (np.ptp(friction) > 0.1) == sticks
        if not sticks:
            # Steady sliding: Coulomb and viscous friction alone.
            assert friction.mean() == pytest.approx(0.5 * 0.5 + 0.4 * speed, rel=0.02)
            assert np.abs(acceleration).max() < 1


def test_energy_does_not_come_from_friction():
    n = 4000
    speed = 0.1 * np.sin(np.arange(n) / 200)
    _, friction = drag(
        speed, np.full(n, 0.5), np.zeros(n), 1 / 4000, 5e-3, 900.0, 2.0, 0.5, 0.6, 0.01, 1e4, 3.0, 0.2
    )
    assert (friction * speed).sum() > 0
    assert np.abs(friction).max() < 2 * 0.6 * 0.5


@pytest.mark.parametrize("name", ["stroking9", "stroking30"])
def test_the_same_seed_gives_the_same_bits_in_any_process(name):
    todo = tasks(name, seed=3, per_class=1, seconds=1)[5:9]
    here = [make(task).id for task in todo]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map(make_id, todo) == here
    assert [make(task).id for task in reversed(todo)] == here[::-1]
    assert make(tasks(name, seed=4, per_class=1, seconds=1)[5]).id not in here


def make_id(task):
    return make(task).id


def test_takes_differ_and_take_n_does_not_depend_on_how_many_there_are():
    few = [r.id for r in simulate("stroking9", seed=0, per_class=1, seconds=0.5)]
    many = [r.id for r in simulate("stroking9", seed=0, per_class=2, seconds=0.5)]
    assert len(set(many)) == 18
    assert few == many[::2]


def test_a_recording_says_what_it_is():
    r = make(tasks("stroking30", seed=0, seconds=4)[0])
    assert r.simulated
    assert (r.material, r.contactor, r.speed_mm_s, r.session) == ("carpet1", "finger", 100.0, "take-1")
    acceleration = r.stream("acceleration")
    assert (acceleration.rate, acceleration.unit, acceleration.axes) == (330.0, "m/s^2", ("x", "y", "z"))
    assert acceleration.seconds == pytest.approx(4, abs=0.02)
    assert np.linalg.norm(acceleration.samples.mean(1)) == pytest.approx(GRAVITY, rel=0.06)
    assert r.stream("force").samples.min() > 0
    assert r.stream("friction").unit == "1"
    assert np.ptp(r.stream("position").samples) == pytest.approx(1e-3 * LENGTH_MM, rel=0.35)
    assert r.image.mm_per_pixel == pytest.approx(0.1)


def test_the_layouts_are_those_of_the_paper():
    todo = tasks("stroking30", seed=0)
    assert len({(t.surface, t.contactor) for t in todo}) == 30
    assert {t.speed_mm_s for t in todo} == {100.0, 200.0, 400.0}
    assert len(todo) == 30 * 3 * 3
    assert {t.seconds for t in todo} == {180.0}
    nine = tasks("stroking9", seed=0, per_class=1)
    assert len(nine) == 9
    assert {t.seconds * t.rate for t in nine} == {4000.0}
    assert all(text.startswith("simulated") for text in simulated_sets().values())


@pytest.mark.parametrize("rate", [330.0, 1000.0, 6000.0, 10_000.0])
def test_rates(rate):
    signal = make(tasks("stroking9", seed=0, per_class=1, seconds=0.5, rate=rate)[4]).stream("acceleration")
    assert signal.rate == rate
    assert len(signal) == pytest.approx(rate / 2, abs=2)


def test_a_stroke_goes_back_and_forth_at_the_speed_asked_for():
    moved = stroke(
        np.random.default_rng(0),
        seconds=20,
        rate=1000,
        speed_mm_s=200,
        force_n=0.7,
        back_and_forth=True,
        unsteadiness=0,
    )
    assert np.median(np.abs(moved.speed_mm_s)) == pytest.approx(200, rel=0.01)
    assert moved.speed_mm_s.min() == pytest.approx(-200, rel=0.01)
    assert np.ptp(moved.path_mm) == pytest.approx(LENGTH_MM, rel=0.15)
    np.testing.assert_allclose(moved.force_n, 0.7)


def test_the_sensor_has_steps_range_noise_and_losses():
    rng = np.random.default_rng(0)
    still = np.zeros((3, 40_000))
    level = np.zeros((3, 1))
    wire = sense(still, 4000.0, level, wired(1000.0), rng)
    assert wire.samples[2].mean() == pytest.approx(GRAVITY, abs=0.01)
    assert wire.samples[0].std() == pytest.approx(100e-6 * GRAVITY * np.sqrt(500), rel=0.2)
    radio = sense(still, 3960.0, level, wireless(330.0), rng)
    assert radio.samples[0].std() == pytest.approx(
        np.hypot(290e-6 * GRAVITY * np.sqrt(165), 0.004 * 9.8 / 12**0.5), rel=0.3
    )
    loud = sense(np.full((3, 4000), 500.0), 4000.0, level, wired(1000.0), rng)
    assert loud.samples.max() <= 16 * GRAVITY + 0.01


def test_turning_keeps_the_length():
    signal = sense(
        np.zeros((3, 8000)), 4000.0, np.array([[0.3], [-0.2], [1.0]]), wired(1000.0), np.random.default_rng(0)
    )
    assert np.linalg.norm(signal.samples.mean(1)) == pytest.approx(GRAVITY, rel=1e-3)


def test_surfaces_are_periodic_and_distinct():
    for surface in STROKING_9:
        heights = height_field(surface)
        inside = np.abs(np.diff(heights, axis=0)).max()
        assert np.abs(heights[0] - heights[-1]).max() <= 1.5 * inside
        assert abs(heights.mean()) < 1e-4
    pixels = [photograph(s).pixels for s in (*STROKING_9, *STROKING_30)]
    assert len({p.tobytes() for p in pixels}) == 24
    assert all(p.std() > 3 for p in pixels)


def test_the_classes_are_separable_but_not_trivially():
    features, classes, takes = [], [], []
    for task in tasks("stroking30", seed=0, per_class=3, seconds=8):
        if task.speed_mm_s != 200:
            continue
        signal = make(task).stream("acceleration")
        n = len(signal) // 200
        windows = signal.samples[:, : n * 200].reshape(3, n, 200)
        power = np.abs(np.fft.rfft(windows * np.hanning(200), axis=-1)) ** 2
        bands = np.stack([power[..., a : a + 6].mean(-1) for a in range(1, 97, 6)], -1)
        features.append(np.log(bands + 1e-9).transpose(1, 0, 2).reshape(n, -1))
        classes += [f"{task.surface}-{task.contactor}"] * n
        takes += [task.take] * n
    x, y, take = np.concatenate(features), np.array(classes), np.array(takes)
    judge = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto").fit(x[take < 3], y[take < 3])
    accuracy = np.mean(judge.predict(x[take == 3]) == y[take == 3])
    assert 0.4 < accuracy < 0.99


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"set_name": "x"}, "simulated set must be one of stroking30, stroking9, got 'x'"),
        ({"per_class": 0}, "per_class must be at least 1, got 0"),
        ({"seconds": 0.0}, "seconds must be 0.1 to 3600, got 0"),
        ({"rate": 5.0}, "rate must be 50 to 20000 Hz, got 5"),
        ({"seed": -1}, "seed must be >= 0, got -1"),
    ],
)
def test_what_cannot_be_simulated_is_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        tasks(**({"set_name": "stroking9", "seed": 0} | options))


def test_a_store_is_marked_simulated(tmp_path: Path):
    from tactogram.datasets import open_store
    from tactogram.jobs.simulate import simulate_to_store

    report = simulate_to_store("stroking9", tmp_path / "s", seed=1, per_class=1, seconds=0.5, workers=2)
    store = open_store(tmp_path / "s")
    assert report["simulated"]
    assert store.simulated
    assert all(info.simulated for info in store.index)
    assert len(store) == 9
    alone = simulate_to_store("stroking9", tmp_path / "t", seed=1, per_class=1, seconds=0.5, workers=1)
    assert alone["sha256"] == report["sha256"]
