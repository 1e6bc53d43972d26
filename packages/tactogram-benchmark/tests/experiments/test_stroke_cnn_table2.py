"""Tables I and II of Saga et al.: what is cross-validated; nothing is trained here."""

import pytest
from made_up_signals import drive

from tactogram.datasets import Recording, create_store
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import artifacts, stroke_cnn_table2


class MadeUpWorkflows:
    """A stroke at each speed; a classifier that is right in nine of ten windows."""

    def __init__(self):
        self.asked = []

    def simulate_to_store(self, name, out, *, seed, progress):
        assert name == "stroking30"
        strokes = (
            Recording(
                streams={"acceleration": drive(n, 1)}, material="felt", speed_mm_s=speed, simulated=True
            )
            for n, speed in enumerate((100.0, 200.0, 400.0))
        )
        create_store(out, strokes, name="made up", licence="-", simulated=True)

    def crossval(self, model, data, *, where, out, on, processes, progress, **options):
        self.asked.append((model, where, options))
        folds = [{"window_accuracy": 0.9}] * options["folds"]
        more = {"recording_accuracy": 1.0, "split": "blocks", "report": "report.html"}
        return {"per_fold": folds, "folds": len(folds), **more}


@pytest.mark.parametrize("paper", [True, False])
def test_30_classes_are_cross_validated_in_ten_parts_by_speed_and_mixed(tmp_path, stand_in, paper):
    """Sec. II-C: "all data was divided into ten parts and 10-fold cross-validation was performed"."""
    made_up = stand_in(MadeUpWorkflows(), stroke_cnn_table2, artifacts)
    found = stroke_cnn_table2.run(tmp_path, paper=paper, progress=silent)
    models, where, options = zip(*made_up.asked, strict=True)
    assert set(models) == {"stroke_cnn"}
    assert where == ({"speed_mm_s": "100"}, {"speed_mm_s": "200"}, {"speed_mm_s": "400"}, {})
    assert {(each["folds"], each["label"]) for each in options} == {(10, "material+contactor")}
    assert {each["recipe"] for each in options} == {"paper" if paper else "quick"}
    assert not any("only_folds" in each for each in options)
    assert [row["ours"] for row in found["rows"].values()] == pytest.approx([90] * 4)
    assert [row["published"] for row in found["rows"].values()] == [89.0, 88.0, 93.2, 88.9]
    assert "simulated" in found["text"]
