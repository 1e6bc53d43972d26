from dataclasses import replace

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.models.ultrasonic_cgan import build
from tactogram.models.ultrasonic_cgan.spectra import sensor_side
from tactogram.training.checkpoint import load_state, save_state
from tactogram.training.loop import TrainingPosition, fit

STICKY = {"rough": 2.0, "sticky": 6.0}


def test_one_stage_per_cluster(tiny, kind, data):
    """Hatori & Takemura 2023, Sec. IV-C: "A separate CGAN was trained for each cluster"."""
    stages = build(tiny, kind, seed=0).stages(data())
    assert [(s.name, s.steps) for s in stages] == [("fit", 1), ("cluster-1", 5), ("cluster-2", 5)]


def test_a_cluster_sees_its_own_surfaces_and_all_display_signals(tiny, kind, data):
    learner, examples = build(tiny, kind, seed=0), data()
    fit_stage, *clusters = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    side = sensor_side(examples[:6], tiny, kind.materials)
    for stage, plates in zip(clusters, ({0, 1}, {2}), strict=True):
        batches = list(learner.batches(stage, examples, seed=0))
        assert sum(len(sensor) for _, (sensor, _), _ in batches) == 24
        assert {int(side.item[row]) for _, (sensor, _), _ in batches for row in sensor.ravel()} == plates
        assert {int(row) for *_, (shown, _) in batches for row in shown.ravel()} == set(range(6))


def test_display_signals_divided_by_cluster_go_to_the_nearest(tiny, kind, data):
    learner, examples = build(tiny.model_copy(update={"display_by_cluster": True}), kind, seed=0), data()
    fit_stage, *clusters = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    seen = [
        {int(row) for *_, (shown, _) in learner.batches(stage, examples, seed=0) for row in shown.ravel()}
        for stage in clusters
    ]
    assert seen == [{3, 4, 5}, {0, 1, 2}]


def test_a_cluster_without_display_signals_is_refused(tiny, kind, data):
    examples = [e for e in data() if e.item not in ("signal00", "signal01", "signal02")]
    learner = build(tiny.model_copy(update={"display_by_cluster": True}), kind, seed=0)
    with pytest.raises(ParameterError, match=r"cluster 2 \(plate03\) has no display signal"):
        fit(learner, examples, seed=0)


def test_scores_beside_the_spectra_are_a_raters_own(tiny, kind, data):
    """Hatori & Takemura 2023, Sec. IV-A: "values of the tactile display as the condition labels"."""
    learner, examples = build(tiny, kind, seed=0), data()
    fit_stage, first, _ = learner.stages(examples)
    learner.step(fit_stage, next(learner.batches(fit_stage, examples, seed=0)))
    _, (sensor, raters), _ = next(learner.batches(first, examples, seed=0))
    side = sensor_side(examples[:6], tiny, kind.materials)
    rows = learner._data.rows(0, sensor, raters)
    np.testing.assert_allclose(rows[2, 3, 60:], side.scores[side.item[sensor[2, 3]]][raters[2, 3]])
    np.testing.assert_allclose(
        rows[2, 3, :60] * learner.surfaces.sensor_scale, side.spectra[sensor[2, 3]], rtol=1e-4, atol=1e-6
    )


def test_with_words_weight_a_signal_follows_its_words(tiny, trained, data, display):
    """Display signals are the stronger the rougher; plates are rough or not, and their spectra of one level."""
    examples = data()[:6] + [display(n, 0.1 * n, 1 - 0.1 * n, level=0.1 + 0.1 * n) for n in range(1, 9)]
    change = {"clusters": 1, "iterations": 400, "choose_after": 399, "iterations_per_step": 50}
    change |= {"learning_rate": 0.01, "dropout_after": ()}
    steps = []
    for weight in (0.0, 10.0):
        learner = trained(tiny.model_copy(update={**change, "words_weight": weight}), examples)
        even, rough = (
            np.mean(
                [
                    learner.generate({"words": {"rough": r, "sticky": 8 - r}}, seed=n).samples.std()
                    for n in range(3)
                ]
            )
            for r in (1.6, 6.4)
        )
        steps.append(rough / even)
    assert steps[0] < 2 < 4 < steps[1], steps


def test_iterations_are_as_many_whatever_a_step_holds(tiny, kind, data, trained):
    for_each = [tiny.model_copy(update={"iterations_per_step": n}) for n in (1, 7, 24)]
    stage_of = [build(config, kind, seed=0).stages(data())[1].steps for config in for_each]
    assert stage_of == [24, 4, 1]
    assert [trained(config).trained[0].curves.shape for config in for_each] == [(3, 24)] * 3


def test_curves_of_every_iteration_and_the_choice_are_kept(learner):
    """Hatori & Takemura 2023, Sec. IV-C, Fig. 5: "the number of iterations at which the generator was selected"."""
    for pair in learner.trained:
        assert pair.curves.shape == (3, 24)
        allowed = pair.curves[0, 3:]
        assert pair.chosen.iteration == int(np.argmin(allowed)) + 4
        assert pair.chosen.loss == allowed.min()


def test_weights_are_those_that_the_chosen_loss_was_of(tiny, kind, data, trained):
    """Trained no further than to the chosen iteration, the generator is the one that was kept."""
    config = tiny.model_copy(update={"clusters": 1, "iterations_per_step": 1})
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

    again = build(config, kind, seed=0)
    with pytest.raises(ReachedError):
        fit(again, data(), seed=0, on_step=stop)
    for name, values in seen[chosen - 1].items():
        if "num_batches" not in name:
            np.testing.assert_array_equal(kept[name], values)


@pytest.mark.parametrize(("stage", "step"), [(1, 2), (1, 5), (2, 3)])
def test_gone_on_with_in_any_cluster_every_curve_and_choice_is_the_same(
    tiny, kind, data, learner, tmp_path, stage, step
):
    """In the middle of the first, at its end, and in the second: to the bit."""
    stopped, resumed = build(tiny, kind, seed=0), build(tiny, kind, seed=0)

    def keep(position, stage_, losses):
        if position == TrainingPosition(stage, step):
            save_state(tmp_path / "state.safetensors", stopped.state())

    fit(stopped, data(), seed=0, on_step=keep)
    resumed.load_state(load_state(tmp_path / "state.safetensors")[0])
    fit(resumed, data(), seed=0, start=TrainingPosition(stage, step))
    for one, other in zip(learner.trained, resumed.trained, strict=True):
        np.testing.assert_array_equal(one.curves, other.curves)
        assert one.chosen == other.chosen
        for name, values in one.generator.state_dict().items():
            np.testing.assert_array_equal(values, other.generator.state_dict()[name])


def test_a_failed_training_is_said_and_generates_nothing(tiny, kind, data):
    """Hatori & Takemura 2023, Sec. IV-C: "we defined the training as a failure"."""
    seen = []
    learner = build(tiny.model_copy(update={"rate_low": 0.98, "rate_high": 0.981}), kind, seed=0)
    fit(learner, data(), seed=0, on_step=lambda position, stage, losses: seen.append(losses))
    assert [losses["failed"] for losses in seen if "failed" in losses] == [1.0, 1.0]
    assert learner.validate(data((7,))) == {"failed_clusters": 2.0}
    assert [cluster["failed"] for cluster in learner.outcome()["clusters"]] == [True, True]
    with pytest.raises(
        ParameterError, match=r"cluster 2 of group B \(plate03\) failed: in none of its 24"
    ) as error:
        learner.generate({"words": STICKY}, seed=0)
    assert "\n" not in str(error.value)
    assert set(learner.figures()) == {"clusters", "selection", "spectra"}


def test_data_without_display_signals_or_with_unrated_surfaces_is_refused(tiny, kind, data):
    with pytest.raises(ParameterError, match="needs rated display signals"):
        build(tiny, kind, seed=0).stages(data()[:6])
    with pytest.raises(ParameterError, match="no training recording of plate03"):
        build(tiny, kind, seed=0).stages([e for e in data() if e.material != "plate03"])
    examples = [replace(e, rated=None) if e.material == "plate02" else e for e in data()]
    with pytest.raises(ParameterError, match="plate02: must be recorded and rated in every word"):
        fit(build(tiny, kind, seed=0), examples, seed=0)
    with pytest.raises(ParameterError, match="at most the 3 surfaces, got 4"):
        build(tiny.model_copy(update={"clusters": 4}), kind, seed=0)
    with pytest.raises(ParameterError, match="rated surfaces and rated signals"):
        build(tiny, replace(kind, words=()), seed=0)
