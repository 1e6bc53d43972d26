from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

from tactogram.errors import ParameterError
from tactogram.model import Example, Rated, SignalKind, unit_scores
from tactogram.models.ultrasonic_cgan import Config, build
from tactogram.models.ultrasonic_cgan.clusters import clusters_of, tree_of
from tactogram.models.ultrasonic_cgan.spectra import display_spectra, filled, sensor_side, sensor_spectra
from tactogram.signal import Signal
from tactogram.training.checkpoint import load_state, save_state
from tactogram.training.loop import Position, fit

RATE = 500.0
WORDS = ("rough", "sticky")
PLATES = ("plate01", "plate02", "plate03")
TINY = Config(
    clusters=2, bins=60, generator_widths=(12, 8), dropout_after=(2,), discriminator_widths=(6,), batch_size=8,
    iterations=24, smooth=4, rate_low=0.0, rate_high=1.0, stored=5, iterations_per_step=5,
)  # fmt: skip
KIND = SignalKind(RATE, "1", ("drive",), PLATES, simulated=True, words=WORDS, scale=(1.0, 7.0))
ROUGH, STICKY = {"rough": 6.4, "sticky": 2.0}, {"rough": 2.0, "sticky": 6.0}


def rated(rough, sticky, seed, raters=4):
    """Simulated."""
    scores = np.random.default_rng(seed).normal((rough, sticky), 0.05, (raters, 2))
    return Rated(WORDS, tuple(f"r{n}" for n in range(raters)), scores.clip(0, 1))


def measurement(plate, seed, rough, sticky):
    samples = np.random.default_rng([seed, plate]).standard_normal((4, 1250)) * (1 + plate) + 3
    signal = Signal(samples, RATE, "V", ("g1", "g2", "g3", "g4"))
    return Example(
        f"{PLATES[plate]}-m{seed}",
        signal,
        PLATES[plate],
        item=PLATES[plate],
        rated=rated(rough, sticky, plate),
    )


def display(number, rough, sticky, level=0.5):
    time = np.arange(500) / RATE
    signal = Signal(level * np.sin(2 * np.pi * (number + 1) * time), RATE, "1", ("drive",))
    return Example(f"d{number}", signal, item=f"signal{number:02d}", rated=rated(rough, sticky, number, 3))


def data(seeds=(0, 1)):
    scores = [(0.9, 0.1), (0.8, 0.2), (0.1, 0.9)]
    surfaces = [measurement(plate, seed, *scores[plate]) for plate in range(3) for seed in seeds]
    return surfaces + [display(n, n / 5, 1 - n / 5) for n in range(6)]


def trained(config=TINY, examples=None):
    learner = build(config, KIND, seed=0)
    fit(learner, examples or data(), seed=0)
    return learner


# -- spectra ------------------------------------------------------------------------------------------------


def test_a_measurement_gives_84_spectra_of_1000_bins():
    """Sec. III-B: four gauges, 21 windows; 12 plates of ten measurements make 10,080."""
    signal = Signal(
        np.random.default_rng(0).standard_normal((4, 25_000)), 10_000.0, "V", ("a", "b", "c", "d")
    )
    found = sensor_spectra(signal, Config())
    assert found.shape == (4, 21, 1000)
    assert 4 * 21 * 10 * 12 == 10_080


def test_spectra_are_those_of_a_plain_transform_of_the_middle_two_seconds():
    signal = measurement(1, 0, 0, 0).signal
    found = sensor_spectra(signal, TINY)
    x = signal.samples[2, 125:1125].astype(float)
    x = (x - x.mean()) / x.std()
    for window in (0, 7, 20):
        start = 25 * window  # 0.05 s
        naive = np.abs(np.fft.rfft(x[start : start + 500])) / 250
        np.testing.assert_allclose(found[2, window], naive[1:61], rtol=1e-4, atol=1e-6)


def test_level_and_offset_of_a_sensor_do_not_matter_and_those_of_a_display_signal_do():
    signal = measurement(0, 0, 0, 0).signal
    np.testing.assert_allclose(
        sensor_spectra(signal.with_samples(0.01 * signal.samples + 5), TINY),
        sensor_spectra(signal, TINY),
        rtol=1e-2,
    )
    drive = display(9, 0, 0, level=0.02).signal
    assert display_spectra(drive, TINY)[0, 0, 9] == pytest.approx(0.02, rel=1e-5)


def test_windows_of_one_measurement_have_its_surface_and_its_raters():
    side = sensor_side(data()[:6], TINY, PLATES)
    assert side.spectra.shape == (6 * 84, 60)
    np.testing.assert_array_equal(side.item, np.repeat([0, 0, 1, 1, 2, 2], 84))
    np.testing.assert_array_equal(side.place[:, 0], np.repeat(range(6), 84))
    np.testing.assert_allclose(side.table[2], rated(0.1, 0.9, 2).scores, rtol=1e-6)
    assert (side.raters == 4).all()


def test_gaps_of_raters_are_their_items_mean():
    scores = np.array([[0.2, np.nan], [0.4, 0.6], [0.9, 0.8]])
    got, gaps = filled(Rated(WORDS, ("a", "b", "c"), scores))
    assert gaps == 1
    np.testing.assert_allclose(got, [[0.2, 0.7], [0.4, 0.6], [0.9, 0.8]], rtol=1e-6)


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Signal(np.ones((1, 1000)), RATE, "V"), "must vary"),
        (Signal(np.zeros((1, 400)), RATE, "V"), "must last 1 s or longer, got 0.8 s"),
        (Signal(np.ones((1, 400)), 100.0, "V"), "above 120; got 100"),
        (Signal(np.ones((1, 400)), 500.5, "V"), "whole number of Hz"),
        (Signal(np.ones((1, 4000)), RATE, "V", domain="displacement"), "over time"),
    ],
)
def test_sensor_signals_of_no_use_are_refused(signal, message):
    with pytest.raises(ParameterError, match=message):
        sensor_spectra(signal, TINY)


# -- clusters -----------------------------------------------------------------------------------------------


def test_clusters_are_those_of_ward_by_hand():
    means = np.array([[0.0, 0.0], [0.1, 0.0], [0.9, 0.9], [0.9, 0.8], [0.5, 0.1]])
    tree = tree_of(means, "ward")
    assert tree[0, 2] == pytest.approx(squareform(pdist(means))[0, 1])
    np.testing.assert_array_equal(clusters_of(tree, 3, items=5), [0, 0, 1, 1, 2])
    np.testing.assert_array_equal(clusters_of(tree, 2, items=5), [0, 0, 1, 1, 0])
    np.testing.assert_array_equal(clusters_of(tree, 1, items=5), [0] * 5)
    np.testing.assert_array_equal(clusters_of(tree, 5, items=5), range(5))
    with pytest.raises(ParameterError, match="at most the 5 surfaces, got 6"):
        clusters_of(tree, 6, items=5)


def test_exactly_as_many_clusters_as_asked_for_even_of_equals():
    means = np.array([[0.0], [1.0], [2.0], [3.0]])
    assert len(set(clusters_of(tree_of(means, "single"), 3, items=4))) == 3


@pytest.mark.parametrize(
    ("count", "group"), [(1, "group A"), (4, "group D"), (12, "group E"), (5, "5 clusters")]
)
def test_groups_have_the_names_of_the_paper(count, group):
    assert Config(clusters=count).group == group


# -- training -----------------------------------------------------------------------------------------------


def test_one_stage_per_cluster():
    stages = build(TINY, KIND, seed=0).stages(data())
    assert [(s.name, s.steps) for s in stages] == [("fit", 1), ("cluster-1", 5), ("cluster-2", 5)]


def test_a_cluster_sees_its_own_surfaces_and_all_display_signals():
    learner, examples = build(TINY, KIND, seed=0), data()
    fit_stage, *clusters = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    side = sensor_side(examples[:6], TINY, PLATES)
    for stage, plates in zip(clusters, ({0, 1}, {2}), strict=True):
        batches = list(learner.batches(stage, examples, seed=0))
        assert sum(len(sensor) for _, sensor, *_ in batches) == 24
        assert {int(side.item[row]) for _, sensor, *_ in batches for row in sensor.ravel()} == plates
        assert {int(row) for *_, shown, _ in batches for row in shown.ravel()} == set(range(6))


def test_display_signals_divided_by_cluster_go_to_the_nearest():
    learner, examples = build(TINY.model_copy(update={"display_by_cluster": True}), KIND, seed=0), data()
    fit_stage, *clusters = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    seen = [
        {int(row) for *_, shown, _ in learner.batches(stage, examples, seed=0) for row in shown.ravel()}
        for stage in clusters
    ]
    assert seen == [{3, 4, 5}, {0, 1, 2}]


def test_a_cluster_without_display_signals_is_refused():
    examples = [e for e in data() if e.item not in ("signal00", "signal01", "signal02")]
    learner = build(TINY.model_copy(update={"display_by_cluster": True}), KIND, seed=0)
    with pytest.raises(ParameterError, match=r"cluster 2 \(plate03\) has no display signal"):
        fit(learner, examples, seed=0)


def test_scores_beside_the_spectra_are_a_raters_own():
    learner, examples = build(TINY, KIND, seed=0), data()
    fit_stage, first, _ = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    _, sensor, (scored, raters), *_ = next(learner.batches(first, examples, seed=0))
    side = sensor_side(examples[:6], TINY, PLATES)
    assert scored is sensor
    rows = learner._data.rows((0, sensor), (0, scored, raters))
    np.testing.assert_allclose(rows[2, 3, 60:], side.scores[side.item[sensor[2, 3]]][raters[2, 3]])
    np.testing.assert_allclose(
        rows[2, 3, :60] * learner.surfaces.sensor_scale, side.spectra[sensor[2, 3]], rtol=1e-4, atol=1e-6
    )


def test_fakes_can_be_scored_as_display_signals_are():
    config = TINY.model_copy(update={"fakes_scored_as": "display"})
    learner, examples = build(config, KIND, seed=0), data()
    fit_stage, first, _ = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    batch = next(learner.batches(first, examples, seed=0))
    _, sensor, (scored, raters), shown, _ = batch
    assert not np.array_equal(scored, shown), "drawn anew, not those of the real half of the batch"
    given = {}
    learner.pair.iterate = lambda x, display: given.update(x=x, display=display) or {}
    learner.step(first, batch)
    side, display_rated = sensor_side(examples[:6], TINY, PLATES), examples[6:]
    np.testing.assert_allclose(
        given["x"][2, 3, :60] * learner.surfaces.sensor_scale,
        side.spectra[sensor[2, 3]],
        rtol=1e-4,
        atol=1e-6,
    )
    np.testing.assert_allclose(
        given["x"][2, 3, 60:], display_rated[scored[2, 3]].rated.scores[raters[2, 3]], rtol=1e-6
    )


def test_iterations_are_as_many_whatever_a_step_holds():
    for_each = [TINY.model_copy(update={"iterations_per_step": n}) for n in (1, 7, 24)]
    stage_of = [build(config, KIND, seed=0).stages(data())[1].steps for config in for_each]
    assert stage_of == [24, 4, 1]
    assert [trained(config).trained[0].curves.shape for config in for_each] == [(3, 24)] * 3


def test_curves_of_every_iteration_and_the_choice_are_kept():
    learner = trained()
    for one in learner.trained:
        assert one.curves.shape == (3, 24)
        allowed = one.curves[0, 3:]
        assert one.chosen.iteration == int(np.argmin(allowed)) + 4
        assert one.chosen.loss == allowed.min()


def test_weights_are_those_that_the_chosen_loss_was_of():
    """Trained no further than to the chosen iteration, the generator is the one that was kept."""
    config = TINY.model_copy(update={"clusters": 1, "iterations_per_step": 1})
    learner = trained(config)
    chosen = learner.trained[0].chosen.iteration
    kept = learner.trained[0].generator.state_dict()
    seen = {}

    class ReachedError(Exception):
        pass

    def stop(position, stage, losses):
        if stage.name != "fit":
            seen[position.step] = {
                k: v.clone() for k, v in again.pair.generator.state_dict().items() if "running" not in k
            }
            if position.step == chosen - 1:
                raise ReachedError

    again = build(config, KIND, seed=0)
    with pytest.raises(ReachedError):
        fit(again, data(), seed=0, on_step=stop)
    for name, values in seen[chosen - 1].items():
        if "num_batches" not in name:
            np.testing.assert_array_equal(kept[name], values)


@pytest.mark.parametrize(("stage", "step"), [(1, 2), (1, 5), (2, 3)])
def test_gone_on_with_in_any_cluster_every_curve_and_choice_is_the_same(tmp_path, stage, step):
    """In the middle of the first, at its end, and in the second: to the bit."""
    whole, stopped, resumed = trained(), build(TINY, KIND, seed=0), build(TINY, KIND, seed=0)

    def keep(position, stage_, losses):
        if position == Position(stage, step):
            save_state(tmp_path / "state.safetensors", stopped.state())

    fit(stopped, data(), seed=0, on_step=keep)
    resumed.load_state(load_state(tmp_path / "state.safetensors")[0])
    fit(resumed, data(), seed=0, start=Position(stage, step))
    for one, other in zip(whole.trained, resumed.trained, strict=True):
        np.testing.assert_array_equal(one.curves, other.curves)
        assert one.chosen == other.chosen
        for name, values in one.generator.state_dict().items():
            np.testing.assert_array_equal(values, other.generator.state_dict()[name])


def test_a_failed_training_is_said_and_generates_nothing():
    seen = []
    learner = build(TINY.model_copy(update={"rate_low": 0.98, "rate_high": 0.981}), KIND, seed=0)
    fit(learner, data(), seed=0, on_step=lambda position, stage, losses: seen.append(losses))
    assert [losses["failed"] for losses in seen if "failed" in losses] == [1.0, 1.0]
    assert learner.validate(data((7,))) == {"failed_clusters": 2.0}
    assert [cluster["failed"] for cluster in learner.outcome()["clusters"]] == [True, True]
    with pytest.raises(
        ParameterError, match=r"cluster 2 of group B \(plate03\) failed: in none of its 24"
    ) as error:
        learner.generate({"words": STICKY}, seed=0)
    assert "\n" not in str(error.value)
    assert set(learner.figures()) == {"clusters", "selection"}


# -- use ----------------------------------------------------------------------------------------------------


def test_the_model_is_that_of_the_cluster_nearest_in_words():
    learner = trained()
    rough, sticky = (learner.chosen_for({"words": words}, 3) for words in (ROUGH, STICKY))
    assert (rough["surface"], rough["cluster"]) == ("plate01", 1)
    assert (sticky["surface"], sticky["cluster"]) == ("plate03", 2)
    assert sticky["cluster_surfaces"] == ["plate03"]
    assert sticky["sensor_spectrum"]["recording"].startswith("plate03")
    assert sticky["distance"] == pytest.approx(np.hypot(0.1 - 1 / 6, 0.9 - 5 / 6), abs=0.1)
    assert 0 <= rough["clamped_amplitude"] <= rough["clamped_bins"] <= 1


def test_a_surfaces_own_means_are_at_no_distance():
    learner = trained()
    means = 1 + 6 * learner.surfaces.means[1]
    found = learner.chosen_for({"words": dict(zip(WORDS, means, strict=True))}, 0)
    assert found["surface"] == "plate02"
    assert found["distance"] == pytest.approx(0, abs=1e-12)


def test_a_loop_has_the_generated_amplitudes_and_no_bin_below_zero():
    learner = trained()
    made = learner._make({"words": ROUGH}, 1)
    signal = learner.generate({"words": ROUGH}, seed=1)
    got = np.abs(np.fft.rfft(signal.samples[0].astype(float))) / 250
    np.testing.assert_allclose(got[1:61], made.amplitudes, atol=1e-6 * made.amplitudes.max())
    assert made.amplitudes.min() >= 0
    assert (signal.rate, signal.unit, signal.axes, len(signal)) == (RATE, "1", ("drive",), 500)


def test_longer_signals_are_whole_loops_and_shorter_ones_the_beginning():
    learner = trained()
    turn = learner.generate({"words": ROUGH}, seed=1).samples
    longer = learner.generate({"words": ROUGH}, seconds=2.5, seed=1).samples
    np.testing.assert_array_equal(longer, np.concatenate((turn, turn, turn[:, :250]), axis=1))
    shorter = learner.generate({"words": ROUGH}, seconds=0.3, seed=1).samples
    np.testing.assert_array_equal(shorter, turn[:, :150])


def test_random_phases_have_a_higher_crest_factor():
    learner = trained()
    low = learner.chosen_for({"words": ROUGH}, 5)["crest_factor"]
    learner.config = learner.config.model_copy(update={"phase": "random"})
    assert learner.chosen_for({"words": ROUGH}, 5)["crest_factor"] > 1.2 * low


def test_a_vibration_of_ones_own_goes_in_instead_of_a_stored_one():
    learner, vibration = trained(), measurement(1, 5, 0, 0).signal
    facts = [learner.chosen_for({"words": ROUGH, "vibration": vibration}, seed) for seed in range(8)]
    assert {fact["sensor_spectrum"]["of"] for fact in facts} == {"vibration"}
    assert len({fact["sensor_spectrum"]["axis"] for fact in facts}) > 1
    assert facts[3] == learner.chosen_for({"words": ROUGH, "vibration": vibration}, 3)
    with pytest.raises(ParameterError, match="condition 'vibration': signal must last 1 s"):
        learner.generate({"words": ROUGH, "vibration": vibration.cut(0, 100)}, seed=0)


def test_scores_are_normalised_as_published():
    """Sec. IV-A: from 1 to 7 to 0 to 1, (x - 1) / 6."""
    np.testing.assert_allclose(unit_scores({"sticky": 7, "rough": 2.5}, KIND), [0.25, 1.0])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rough": 3}, "a score is needed of sticky"),
        ({"rough": 3, "sticky": 2, "loud": 3}, "words must be of rough, sticky; got 'loud'"),
        ({"rough": 8, "sticky": 2}, "rough must be 1 to 7, got 8"),
        ({"rough": float("nan"), "sticky": 2}, "got nan"),
    ],
)
def test_words_that_cannot_be_answered_are_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        unit_scores(words, KIND)


# -- what it refuses to learn from --------------------------------------------------------------------------


def test_data_without_display_signals_or_with_unrated_surfaces_is_refused():
    with pytest.raises(ParameterError, match="needs rated display signals"):
        build(TINY, KIND, seed=0).stages(data()[:6])
    with pytest.raises(ParameterError, match="no training recording of plate03"):
        build(TINY, KIND, seed=0).stages([e for e in data() if e.material != "plate03"])
    examples = [replace(e, rated=None) if e.material == "plate02" else e for e in data()]
    with pytest.raises(ParameterError, match="plate02: must be recorded and rated in every word"):
        fit(build(TINY, KIND, seed=0), examples, seed=0)
    with pytest.raises(ParameterError, match="at most the 3 surfaces, got 4"):
        build(TINY.model_copy(update={"clusters": 4}), KIND, seed=0)
    with pytest.raises(ParameterError, match="rated surfaces and rated signals"):
        build(TINY, replace(KIND, words=()), seed=0)


def test_a_copy_of_a_display_signal_and_a_collapse_show_in_the_figures():
    learner = trained()
    figures = learner.validate(data((7,)))
    assert figures["failed_clusters"] == 0
    assert {"told_apart_unseen", "between_surfaces", "to_nearest_display", "clamped_bins"} <= set(figures)
    generator = learner.trained[0].generator
    for layer in generator.layers:
        if hasattr(layer, "weight"):
            layer.weight.data.zero_()
    generator.layers[-2].bias.data.zero_()
    generator.layers[-2].bias.data[4] = 0.5 / learner.surfaces.display_scale  # the display's 5 Hz, as it is
    learner.trained[1] = learner.trained[0]
    figures = learner.validate(data((7,)))
    assert figures["between_surfaces"] == pytest.approx(0, abs=1e-6)
    assert figures["to_nearest_display"] == pytest.approx(0, abs=1e-3)
