import json

from tactogram.workflows.results_table import evaluation_results
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.runs import RunCatalogue, run_summary

"""Finished runs of a workspace."""


KIND = {"rate": 1000.0, "unit": "m/s^2", "axes": ["x", "y", "z"], "materials": ["a", "b"]}


def test_runs_of_a_task_are_found_and_damaged_ones_left_out(tmp_path):
    run = tmp_path / "runs" / "nine"
    run.mkdir(parents=True)
    (run / "recipe.toml").write_text('model = "stroke_cnn"\n')
    (run / "data.json").write_text('{"name": "nine"}')
    (run / "model.json").write_text(json.dumps({"model": "stroke_cnn", "kind": KIND}))
    catalogue = RunCatalogue(Workspace.at(tmp_path))
    [found] = catalogue.own("classification")
    assert (found.name, found.kind.materials, found.data["name"]) == ("runs/nine", ("a", "b"), "nine")
    assert catalogue.own("generation") == []
    (run / "model.json").write_text("[1]")
    assert RunCatalogue(Workspace.at(tmp_path)).own("classification") == []


def test_a_summary_has_the_results_of_a_run(workspace):
    summary = run_summary(workspace / "studio/first/voices")
    assert (summary.model, summary.finished, summary.simulated) == ("ar_texture", True, True)
    evaluation = {"window_accuracy": 0.5, "recordings": 3, "measures": {"lsd_db": {"model": 2.0, "floor": 1}}}
    assert evaluation_results(evaluation) == {"window_accuracy": 0.5, "lsd_db": 2.0}
    assert run_summary(workspace / "nothing").model == "unknown"
