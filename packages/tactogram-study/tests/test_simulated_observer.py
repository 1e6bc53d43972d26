import numpy as np
import pytest
from scipy.stats import norm

from tactogram_study.designs.analysis.magnitude import intensity_of
from tactogram_study.designs.staircase import Staircase
from tactogram_study.simulated_observer import SimulatedEffect, typical
from tactogram_study.simulated_participants import SimulatedParticipant, simulated_answers
from tactogram_study.study_file import Study


def test_simulated_participants_can_have_exponents_of_their_own():
    drawn = [SimulatedParticipant(SimulatedEffect(exponent=0.8, exponent_sd=0.2), (3, n)) for n in range(300)]
    exponents = np.array([one.exponent for one in drawn])
    assert exponents.mean() == pytest.approx(0.8, abs=3 * 0.2 / np.sqrt(300))
    assert exponents.std() == pytest.approx(0.2, rel=0.13)
    study = Study.load("magnitude", changes={"design.repeats": 2, "practice": None})
    steep = SimulatedEffect(exponent=0.8, exponent_sd=0.5, within_sd=0.0)
    answers = simulated_answers(study, 3, effect=steep, seed=3).where(design="magnitude")
    for number, own in enumerate(answers.by("participant").values(), 1):
        slope = np.polyfit(np.log([intensity_of(row) for row in own]), np.log([row.value for row in own]), 1)[
            0
        ]
        assert slope == pytest.approx(SimulatedParticipant(steep, (3, number)).exponent, abs=1e-3)


def test_spreads_between_people_change_no_other_answer(make_study):
    study = make_study("rating")
    spread = SimulatedEffect(preference_sd=1.0, exponent_sd=0.3)
    assert simulated_answers(study, 2, effect=spread).rows == simulated_answers(study, 2).rows


def test_a_staircases_item_can_have_a_threshold_of_its_own_and_items_can_be_alike(make_study, taken, trials):
    pages, _ = taken(make_study("staircase"))
    page = trials(pages)[0]
    item = page.questions[0].stimulus
    same = SimulatedEffect(threshold_db=page.questions[0].values["A"], lapse=0.0)
    harder = same.model_copy(update={"shift": {item: 4.0}})
    everybody = [
        SimulatedParticipant(effect.model_copy(update={"threshold_sd_db": 0.0}), (0, 1))
        for effect in (same, harder)
    ]
    sure = [Staircase.simulated_share(page, one) for one in everybody]
    assert sure == pytest.approx([0.75, 0.5 + 0.5 * norm.cdf(-1)])
    assert typical(SimulatedEffect(typical_sd=0), 1, "plate", "rough") == 0
    assert typical(SimulatedEffect(typical_sd=2), 1, "plate", "rough") == pytest.approx(
        2 * typical(SimulatedEffect(), 1, "plate", "rough")
    )
