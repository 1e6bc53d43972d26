from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.signal import welch
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram.datasets.simulate import make, simulated_sets, tasks
from tactogram.datasets.simulate.contact import FINGER, PEN, Bristles, feel, transmission
from tactogram.datasets.simulate.materials import STROKING_9, STROKING_30
from tactogram.datasets.simulate.photo import photograph
from tactogram.datasets.simulate.sensor import GRAVITY, sense, turn, wired, wireless
from tactogram.datasets.simulate.sets import SETS
from tactogram.datasets.simulate.stroke import LENGTH_MM, TURN_M_S2, Stroke, stroke
from tactogram.datasets.simulate.surfaces import PATCH_MM, Grating, Roughness, Surface, height_field
from tactogram.errors import ParameterError

RATE = 8000.0


def steady(speed, seconds=2.0, force=0.7):
    n = int(seconds * RATE)
    return Stroke(RATE, np.arange(n) * speed / RATE, np.zeros(n), np.full(n, force))


@settings(deadline=None, max_examples=15)
@given(st.sampled_from([1.0, 1.6, 2.4, 4.0]), st.floats(40, 300), st.sampled_from([FINGER, PEN]))
def test_spatial_frequency_times_speed_is_what_is_felt(period, speed, contactor):
    ridges = Surface(f"ridges-{period}", (Grating(period, 0.02),), 0.4, 1.0)
    felt = feel(ridges, contactor, steady(speed), start_mm=(0, 0), direction_deg=0)
    f, power = welch(felt.normal[2000:], RATE, nperseg=len(felt.normal) - 2000)
    expected = speed * round(PATCH_MM / period) / PATCH_MM
    harmonic = np.round(f / expected)
    on_comb = (np.abs(f - harmonic * expected) <= 2 * f[1]) & (harmonic >= 1)
    # A slow pen feels a fine grating twice per period as strongly as once, so the strongest line alone says nothing.
    assert power[on_comb].sum() > 0.9 * power.sum()
    assert power[on_comb & (harmonic == 1)].sum() > 0.25 * power.sum()


@pytest.mark.parametrize("contactor", [FINGER, PEN])
def test_vibration_grows_with_speed(contactor):
    rough = Surface("rough", (Roughness(0.01, 2.0, 0.2, 4),), 0.4, 1.0)
    level = [
        feel(rough, contactor, steady(speed), start_mm=(0, 0), direction_deg=10).normal[2000:].std()
        for speed in (50, 100, 200, 400)
    ]
    assert np.all(np.diff(np.log(level)) > 0.2)


@pytest.mark.parametrize("contactor", [FINGER, PEN])
def test_the_shift_in_frequency_accounts_for_the_growth_with_speed(contactor):
    """What is felt at one speed says what is felt at others, by a shift alone (Greenspon et al. 2019)."""
    rough = Surface("rough", (Roughness(0.003, 2.0, 0.2, 4),), 0.4, 1.0, stiffness_n_m=1e9)

    def power_at(speed):
        moved = steady(speed, seconds=400 / speed)
        felt = feel(rough, contactor, moved, start_mm=(0, 0), direction_deg=10)
        return welch(felt.normal[2000:], RATE, nperseg=int(40 / speed * RATE))

    def gain(f):
        m, c, s = contactor.mass_kg, contactor.damping_n_s_m, contactor.stiffness_n_m
        w = 2 * np.pi * f
        return np.abs(w**2 * (1j * w * c + s) / (s - m * w**2 + 1j * w * c)) ** 2

    f, power = power_at(60)
    heights = power[1:] / gain(f[1:])
    for speed in (30, 120, 240):
        shift = speed / 60
        expected = (heights * gain(f[1:] * shift)).sum() * f[1]
        f_fast, power_fast = power_at(speed)
        assert power_fast.sum() * f_fast[1] == pytest.approx(expected, rel=0.15)


def dragged(speed, mass=1e-3, seconds=2.0):
    """Return a mass of 1 g on a spring of 1 N/mm over a flat surface: the parameters of the reference."""
    block = replace(
        FINGER, grip_mass_kg=mass, grip_n_m=1000.0, grip_n_s_m=0.0, stiffness_n_m=1000.0, damping_n_s_m=1.0
    )
    flat = Surface("flat", (Grating(1, 0),), friction=0.5, stiction=1.8, stribeck_mm_s=10)
    moved = steady(speed, seconds=seconds, force=0.5)
    steel = Bristles(1e5, 1e5**0.5, 0.4)  # Canudas de Wit et al. 1995
    return feel(flat, block, moved, start_mm=(0, 0), direction_deg=0, bristles=steel)


@pytest.mark.parametrize("speed", [10, 50])
def test_it_sticks_and_slips_when_slow(speed):
    felt = dragged(speed)
    friction = felt.friction_n[len(felt.friction_n) // 2 :]
    place = felt.place_m[len(felt.place_m) // 2 :]
    velocity = np.diff(place) * RATE
    assert np.ptp(friction) > 0.1
    assert np.mean(np.abs(velocity) < 2e-3) > 0.2
    assert velocity.mean() == pytest.approx(1e-3 * speed, rel=0.1)
    # Static friction is reached; what is above it is what bending the bristles adds (sigma1 z').
    assert 0.9 * 0.9 * 0.5 < friction.max() < 1.5 * 0.9 * 0.5


def test_it_slides_smoothly_when_fast():
    felt = dragged(250)
    half = len(felt.friction_n) // 2
    # Coulomb and viscous friction alone.
    assert felt.friction_n[half:].mean() == pytest.approx(0.5 * 0.5 + 0.4 * 0.25, rel=0.01)
    assert np.ptp(felt.friction_n[half:]) < 0.01
    assert np.abs(felt.along[half:]).max() < 1


@pytest.mark.parametrize("speed", [20, 100, 300])
def test_friction_takes_energy(speed):
    felt = dragged(speed, seconds=1.0)
    velocity = np.gradient(felt.place_m) * RATE
    assert (felt.friction_n * velocity).sum() > 0


def test_a_light_contactor_leaves_a_rough_surface_and_its_force_is_never_negative():
    ridges = Surface("high ridges", (Grating(2.0, 0.5),), 0.4)
    felt = feel(ridges, PEN, steady(400, 1.0), start_mm=(0, 0), direction_deg=0)
    assert felt.force_n.min() == 0
    flying = felt.force_n == 0
    # In the air the load of the hand alone pulls.
    free = flying & np.roll(flying, 1)
    np.testing.assert_allclose(felt.normal[free], -0.7 / PEN.mass_kg, rtol=1e-6)


def test_the_contact_follows_its_equation():
    """m z'' + b (z' - u') + k (z - u) = 0 for a small sine: gain and resonance as the formula says."""
    for period, speed in ((2.0, 100.0), (1.0, 200.0)):
        sine = Surface(f"sine-{period}", (Grating(period, 1e-4),), 0.4, 1.0, stiffness_n_m=1e9)
        felt = feel(sine, FINGER, steady(speed), start_mm=(0, 0), direction_deg=0)
        k = round(PATCH_MM / period) / PATCH_MM
        w = 2 * np.pi * k * speed
        u = 0.5e-7 * transmission(FINGER, np.array(k))
        m, c, s = FINGER.mass_kg, FINGER.damping_n_s_m, FINGER.stiffness_n_m
        expected = w**2 * u * abs((1j * w * c + s) / (s - m * w**2 + 1j * w * c))
        assert felt.normal[4000:].std() * np.sqrt(2) == pytest.approx(expected, rel=0.01)


def test_the_same_seed_gives_the_same_bits_in_any_order():
    todo = tasks("stroking30", seed=3, per_class=1, seconds=1)[5:9]
    ids = [make(task).id for task in todo]
    assert [make(task).id for task in reversed(todo)] == ids[::-1]
    assert make(replace(todo[0], seed=4)).id not in ids


def test_takes_differ_and_take_n_does_not_depend_on_how_many_there_are():
    few = [make(task).id for task in tasks("stroking9", seed=0, per_class=1, seconds=0.5)[4:6]]
    many = [make(task).id for task in tasks("stroking9", seed=0, per_class=2, seconds=0.5)[8:12]]
    assert len(set(many)) == 4
    assert few == many[::2]


def test_a_recording_says_what_it_is():
    r = make(tasks("stroking30", seed=0, seconds=4)[0])
    assert r.simulated
    assert (r.material, r.contactor, r.speed_mm_s, r.session) == ("carpet1", "finger", 100.0, "take-1")
    acceleration = r.stream("acceleration")
    assert (acceleration.rate, acceleration.unit, acceleration.axes) == (330.0, "m/s^2", ("x", "y", "z"))
    assert acceleration.seconds == pytest.approx(4, abs=0.02)
    assert np.linalg.norm(acceleration.samples.mean(1)) == pytest.approx(GRAVITY, rel=0.02)
    assert r.stream("force").samples.min() > 0
    assert r.stream("friction").unit == "1"
    assert r.stream("position").axes == ("x", "y")
    assert np.ptp(r.stream("position").axis("x")) == pytest.approx(1e-3 * LENGTH_MM, rel=0.2)
    assert r.labels == {"recording": "1"}
    assert any("packets" in line for line in r.history)
    assert r.image.mm_per_pixel == pytest.approx(0.15)


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


@pytest.mark.parametrize("speed", [100, 200, 400])
def test_a_stroke_goes_back_and_forth_at_the_speed_asked_for(speed):
    moved = stroke(
        np.random.default_rng(0),
        seconds=20,
        rate=1000,
        speed_mm_s=speed,
        force_n=0.7,
        back_and_forth=True,
        unsteadiness=0,
    )
    velocity = np.diff(moved.path_mm) * 1000
    assert np.median(np.abs(velocity)) == pytest.approx(speed, rel=0.01)
    assert np.abs(velocity).max() == pytest.approx(speed, rel=0.01)
    assert np.ptp(moved.path_mm) == pytest.approx(LENGTH_MM, rel=0.1)
    assert np.abs(np.diff(velocity) * 1000).max() < 2.5 * 1e3 * TURN_M_S2
    np.testing.assert_allclose(moved.force_n, 0.7)
    np.testing.assert_allclose(moved.sideways_mm, 0)


def test_a_hand_stays_on_its_plate_and_presses_on():
    moved = stroke(
        np.random.default_rng(1), seconds=180, rate=500, speed_mm_s=200, force_n=0.7, back_and_forth=True
    )
    assert np.ptp(moved.path_mm) < 130
    assert moved.force_n.min() > 0
    assert moved.force_n.std() / 0.7 == pytest.approx(0.1, rel=0.4)
    assert np.ptp(moved.sideways_mm) > 1


@pytest.mark.parametrize("seed", range(8))
def test_a_hand_does_not_stop_dead_where_the_recording_ends(seed):
    moved = stroke(
        np.random.default_rng(seed),
        seconds=4,
        rate=2000,
        speed_mm_s=200,
        force_n=0.7,
        back_and_forth=True,
    )
    # m/s^2; a turn takes 2.5 times the mean.
    acceleration = np.diff(moved.path_mm, 2) * 2000**2 * 1e-3
    assert np.abs(acceleration).max() < 4 * TURN_M_S2


def test_a_stroke_in_one_direction_never_turns():
    moved = stroke(
        np.random.default_rng(2), seconds=4, rate=1000, speed_mm_s=100, force_n=0.7, back_and_forth=False
    )
    assert np.diff(moved.path_mm).min() >= 0
    assert moved.path_mm[-1] == pytest.approx(385, rel=0.05)


def test_the_sensor_has_steps_range_noise_and_losses():
    rng = np.random.default_rng(0)
    still = np.zeros((3, 160_000))
    level = np.zeros((3, 1))
    wire, lost = sense(still, 4000.0, level, wired(1000.0), rng)
    assert lost == 0
    assert wire.samples[2].mean() == pytest.approx(GRAVITY, abs=0.01)
    assert wire.samples[0].std() == pytest.approx(100e-6 * GRAVITY * np.sqrt(500), rel=0.05)
    steps = wire.samples / (32 * GRAVITY / 2**16)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-2)
    radio, lost = sense(still, 3960.0, level, wireless(330.0), rng)
    assert radio.rate == 330
    assert len(radio) == pytest.approx(330 * 160_000 / 3960, abs=2)
    assert 1 <= lost <= 20
    for axis, density in (("x", 290e-6), ("z", 430e-6)):
        noise = np.hypot(density * GRAVITY * np.sqrt(165), 0.004 * GRAVITY / 12**0.5)
        assert radio.axis(axis).std() == pytest.approx(noise, rel=0.1)
    loud, _ = sense(np.full((3, 4000), 500.0), 4000.0, level, wired(1000.0), rng)
    assert loud.samples.max() <= 16 * GRAVITY + 0.01


def test_lost_packets_add_nothing_that_was_not_there():
    rng = np.random.default_rng(0)
    shaken = 20 * rng.standard_normal((3, 80_000))
    radio, lost = sense(shaken, 3960.0, np.zeros((3, 1)), replace(wireless(), lost=0.2), rng)
    assert lost > 50
    assert np.abs(radio.samples).max() < 1.5 * 20 * 5 / np.sqrt(12)


def test_turning_keeps_the_length():
    signal, _ = sense(
        np.zeros((3, 8000)), 4000.0, np.array([[0.3], [-0.2], [1.0]]), wired(1000.0), np.random.default_rng(0)
    )
    assert np.linalg.norm(signal.samples.mean(1)) == pytest.approx(GRAVITY, rel=1e-3)
    # Leaning back about y shows gravity along the stroke.
    leaned = turn(np.array([[0.0], [0.0], [1.0]]), np.deg2rad([[0.0], [30.0], [0.0]]))
    np.testing.assert_allclose(np.abs(leaned[:, 0]), [0.5, 0, np.sqrt(0.75)], atol=1e-12)


def test_surfaces_are_periodic_and_distinct():
    pixels = []
    for surface in (*STROKING_9[::3], STROKING_30[9]):
        heights = height_field(surface)
        inside = np.abs(np.diff(heights, axis=0)).max()
        assert np.abs(heights[0] - heights[-1]).max() <= 1.5 * inside
        assert abs(heights.mean()) < 1e-4
        pixels.append(photograph(surface).pixels)
    assert len({p.tobytes() for p in pixels}) == 4
    assert all(p.std() > 3 for p in pixels)


def test_the_classes_are_separable_but_not_trivially():
    features, classes, takes = [], [], []
    for task in tasks("stroking30", seed=0, per_class=3, seconds=6.1, own_images=False):
        if task.speed_mm_s != 200 or task.surface % 5:  # every fifth surface, with either contactor
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
        ({"set_name": "x"}, "simulated set must be one of stroking30, .*, tactile_images, got 'x'"),
        ({"per_class": 0}, "per_class must be at least 1, got 0"),
        ({"seconds": 0.0}, "seconds must be 0.1 to 3600, got 0"),
        ({"rate": 5.0}, "rate must be 50 to 20000 Hz, got 5"),
        ({"seed": -1}, "seed must be >= 0, got -1"),
    ],
)
def test_what_cannot_be_simulated_is_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        tasks(**({"set_name": "stroking9", "seed": 0} | options))


def test_a_store_is_marked_simulated_and_the_same_from_any_number_of_processes(tmp_path, monkeypatch):
    from tactogram.datasets import open_store
    from tactogram.workflows.data.simulate import simulate_to_store

    nine = SETS["stroking9"]
    monkeypatch.setitem(SETS, "stroking9", replace(nine, surfaces=nine.surfaces[:1]))
    report = simulate_to_store("stroking9", tmp_path / "s", seed=1, per_class=4, seconds=0.5, workers=2)
    store = open_store(tmp_path / "s")
    assert report["simulated"]
    assert store.simulated
    assert all(info.simulated for info in store.index)
    assert len(store) == 4
    alone = simulate_to_store("stroking9", tmp_path / "t", seed=1, per_class=4, seconds=0.5, workers=1)
    assert alone["sha256"] == report["sha256"]
