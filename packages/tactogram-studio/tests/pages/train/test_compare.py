from tactogram_studio.pages.train.compare import loss_by_run, loss_options


def test_a_comparison_shows_the_loss_of_the_runs_that_have_it():
    curves = {"r1": {"loss": [(1, 2.0)]}, "r2": {"other": [(1, 1.0)]}}
    assert loss_by_run(curves, "loss") == {"r1": [(1, 2.0)]}


def test_only_positive_losses_are_shown_on_a_logarithmic_scale():
    assert loss_options({"a": [(1, 1.0)]}, log_scale=True)["yAxis"]["type"] == "log"
    assert loss_options({"a": [(1, -1.0)]}, log_scale=True)["yAxis"]["type"] == "value"
