"""Figs. 4 to 6 of Hatori et al. 2025: what is trained, kept and said; nothing is trained here."""

import csv

import pytest
from made_up_images import PLATES, MadeUpWorkflows

from tactogram.datasets.ratings.words import WORDS
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    cross_modal,
    image_cells,
    tactile_image_cgan_figure4 as figure4,
)


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), figure4, cross_modal, image_cells, artifacts)


def test_cross_modal_has_six_conditions_and_two_groups_of_people(tmp_path):
    """Hatori et al. 2025, Sec. III-B, Fig. 5: w/o Models, w/o Images and four weights."""
    found = cross_modal.run(tmp_path, paper=False, progress=silent)
    assert list(found["overall"]) == [
        "without models", "without images", "weight 1", "weight 1000", "weight 5000", "weight 10000"
    ]  # fmt: skip
    assert found["told_by"] == "simulated observers"
    assert found["plates"]["judged"] == ["plate01", "plate02"]
    assert "no signal of plate03: the training of their cluster failed" in found["text"]
    assert 0.9 * 20 * 2 * 10 < found["overall"]["weight 1"]["n"] <= 20 * 2 * 10
    assert found["by_person"]["groups"]["weight 1"]["n"] == 20
    assert found["people_in_both_groups"] == []
    with (tmp_path / "items.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 * 2
    assert {bool(row["image"]) for row in rows if row["item"].startswith("without")} == {False}
    assert all((tmp_path / row["vibration"]).is_file() for row in rows)
    assert (tmp_path / "figure5.png").is_file()
    assert (tmp_path / "figure6.png").is_file()


def test_cross_modal_of_real_answers_says_people(tmp_path, made_up):
    """Answers that repeat the plates' means err by nothing; those of the others by one point."""
    targets = made_up.generate_rated_surfaces(None, seed=0).targets
    lines = ["rater,item,word,score"]
    for condition in ("without models", "without images", *(f"weight {w}" for w in (1, 1000, 5000, 10000))):
        for rater in ("p1", "p2", "p3"):
            for plate in PLATES[:2]:
                for word, mean in zip(WORDS, targets[plate], strict=True):
                    score = round(mean) if condition == "weight 5000" else 1 + (round(mean) % 7)
                    lines.append(f"{rater},{condition}/{plate},{word},{score}")
    (tmp_path / "answers.csv").write_text("\n".join(lines) + "\n")
    found = cross_modal.run(
        tmp_path / "out", paper=False, progress=silent, ratings=str(tmp_path / "answers.csv")
    )
    assert found["told_by"] == "people"
    assert found["people_in_both_groups"] == ["p1", "p2", "p3"]
    assert "3 people are in both groups: p by person treats them as different people" in found["text"]
    assert found["overall"]["weight 5000"]["mean"] < 0.3 < found["overall"]["weight 1"]["mean"]
