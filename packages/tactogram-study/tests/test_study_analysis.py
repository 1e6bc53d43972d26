import json
from dataclasses import replace

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.analysis.findings import EQUIVALENT, NOT_SHOWN, SHOWN, UNDECIDED, verdict_of
from tactogram_study.answers import Answer, Answers
from tactogram_study.designs import find_design
from tactogram_study.designs.analysis.pairwise import bradley_terry
from tactogram_study.designs.analysis.staircase import reversals_of
from tactogram_study.planned import AnalysisPlan
from tactogram_study.statistics import pooled_share, share_of
from tactogram_study.study_analysis import analyse

ITEMS = ("cloth", "cork", "tile")


def simulated(design, question, rows):
    """Return answers of simulated participants; a row is (participant, trial, columns)."""
    return Answers(
        tuple(
            Answer(
                study="sim",
                participant=f"P{p:02d}",
                trial=t,
                **{"design": design, "question": question, "simulated": True, "answer": "-"} | columns,
            )
            for p, t, columns in rows
        )
    )


def which(people=10, trials=60, logit=0.0, sd=0.4, seed=0, design="two_area"):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        own = 1 / (1 + np.exp(-(logit + sd * rng.standard_normal())))
        for t in range(trials):
            right = bool(rng.random() < own)
            side = "AB"[rng.integers(2)]
            answer = side if right else "AB".replace(side, "")
            rows.append(
                (
                    p,
                    t + 1,
                    {
                        "stimulus": ITEMS[t % 3],
                        "side": side,
                        "answer": answer,
                        "value": float(right),
                        "correct": right,
                    },
                )
            )
    return simulated(design, "which", rows)


def realism(people=10, marks=20, gap=0.0, gap_sd=3.0, seed=0):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        level, own = 55 + 8 * rng.standard_normal(), gap + gap_sd * rng.standard_normal()
        for t in range(marks):
            for condition, shift in (("generated", own), ("recorded", 0.0)):
                value = float(np.clip(level + shift + 10 * rng.standard_normal(), 0, 100))
                rows.append((p, t + 1, {"stimulus": ITEMS[t % 3], "condition": condition, "value": value}))
    return simulated("two_area", "realism", rows)


def scores(noise, people=12, items=4, seed=0):
    """Return scores of two words, and the targets they scatter around, by condition."""
    rng = np.random.default_rng(seed)
    targets = {f"plate{k}": {"rough": float(2 + k), "dry": 4.0} for k in range(items)}
    rows = []
    for p in range(people):
        for condition, sd in noise.items():
            for item, words in targets.items():
                for word, target in words.items():
                    value = float(np.clip(np.round(target + sd * rng.standard_normal()), 1, 7))
                    rows.append(
                        (p, 1, {"question": word, "condition": condition, "stimulus": item, "value": value})
                    )
    return simulated("rating", "", rows), targets


def only(analysis):
    [section] = analysis.sections
    return section


def finding(section, of, test, role=None):
    return next(
        f for f in section.findings if f.of == of and f.test.startswith(test) and role in (None, f.role)
    )


def test_the_texture_table_counts_the_people_at_chance():
    right = {0: 5, 1: 8, 2: 9, 3: 10, 4: 1}
    rows = [
        (p, t + 1, {"stimulus": "cork", "value": float(t < count), "correct": t < count})
        for p, count in right.items()
        for t in range(10)
    ]
    answers = simulated("two_area", "which", rows)
    [row] = only(analyse(answers)).tables["share correct per texture"]
    assert row["at_chance"] == "2 of 5"  # of 10 answers, 9 or more and 1 or fewer differ from one half at .05
    section = only(analyse(answers, plan=AnalysisPlan({}, alpha=0.005)))
    assert section.tables["share correct per texture"][0]["at_chance"] == "4 of 5"
    [note] = [note for note in section.notes if note.startswith("at_chance")]
    assert "exact binomial" in note
    assert "p >= 0.005" in note


def test_verdicts_never_say_that_there_is_no_difference():
    assert verdict_of(0.01) == verdict_of(0.01, equivalence_p=0.01) == SHOWN
    assert verdict_of(0.9) == NOT_SHOWN
    assert verdict_of(0.9, equivalence_p=0.04) == EQUIVALENT
    assert verdict_of(0.9, equivalence_p=0.06) == UNDECIDED


def test_an_effect_on_which_is_generated_is_shown_and_its_absence_is_equivalence():
    [there] = only(analyse(which(logit=0.8))).role("confirmatory")
    assert there.verdict == SHOWN
    assert there.low < 1 / (1 + np.exp(-0.8)) < there.high
    absent = which(trials=90, sd=0.1)
    [nothing] = only(analyse(absent, plan=AnalysisPlan({"which": 0.1}))).role("confirmatory")
    assert nothing.verdict == EQUIVALENT
    [without] = only(analyse(absent)).role("confirmatory")
    assert without.verdict == NOT_SHOWN


def test_ten_trials_are_undecided():
    section = only(analyse(which(people=1, trials=10, seed=1), plan=AnalysisPlan({"which": 0.1})))
    [one] = section.role("confirmatory")
    assert (one.verdict, one.participants) == (UNDECIDED, 1)
    assert "one participant" in one.note
    assert [row["verdict"] for row in section.tables["share correct per texture"]] == [UNDECIDED] * 3


def test_the_default_test_errs_less_than_that_of_all_answers_where_people_differ():
    sound = printed = 0
    for seed in range(20):
        answers = which(people=8, trials=60, sd=0.9, seed=seed)
        hits = answers.numbers()
        sound += pooled_share(hits, answers.column("participant")).p < 0.05
        printed += share_of(int(hits.sum()), len(hits)).p < 0.05
    assert sound <= 4 < printed


def test_abx_gives_the_d_prime_of_abx():
    section = only(analyse(which(logit=0.8, design="abx")))
    assert section.title.startswith("ABX")
    assert section.role("confirmatory")[0].effect["d'"] > 1.3  # 2AFC would be 0.7
    assert not section.role("as printed")


def test_a_gap_in_realism_is_shown_with_its_size_and_its_absence_is_equivalence():
    there = only(analyse(realism(gap=-10.0), plan=AnalysisPlan({"realism": 5.0})))
    [gap] = there.role("confirmatory")
    assert gap.verdict == SHOWN
    assert gap.measure == "generated minus recorded, mm"
    assert gap.low < -10 < gap.high
    assert gap.effect["dz"] < -1
    mixed = finding(there, "all", "linear mixed model")
    assert mixed.estimate == pytest.approx(gap.estimate, abs=0.8)
    [nothing] = only(analyse(realism(gap_sd=1.0), plan=AnalysisPlan({"realism": 5.0}))).role("confirmatory")
    assert nothing.verdict == EQUIVALENT


def test_students_t_stands_beside_as_it_was_printed():
    section = only(analyse(realism(gap=-10.0)))
    printed = section.role("as printed")
    assert [f.of for f in printed] == list(ITEMS)
    assert {f.test for f in printed} == {"Student's t, uncorrected"}
    assert any("independent" in note for note in section.notes)


def test_realism_needs_two_conditions_and_two_people():
    with pytest.raises(DataError, match="two conditions"):
        analyse(realism().where(condition="recorded"))
    with pytest.raises(DataError, match="two participants"):
        analyse(realism(people=1))


def test_smaller_errors_of_words_are_shown_by_participant():
    answers, targets = scores({"none": 2.2, "1": 1.0, "5,000": 0.6})
    section = only(analyse(answers, plan=AnalysisPlan({"rating": 0.2}, targets=targets, draws=200)))
    assert finding(section, "all words", "Friedman").verdict == SHOWN
    assert finding(section, "none minus 5,000", "Wilcoxon", "confirmatory").estimate > 0.5
    assert (
        finding(section, "rough, none minus 5,000", "Steel-Dwass", "as printed").correction == "Steel-Dwass"
    )
    overall, words = section.tables.values()
    assert [row["condition"] for row in overall] == ["none", "1", "5,000"]
    assert all(row["low"] < row["mean"] < row["high"] for row in (*overall, *words))
    none = np.concatenate(
        [[abs(r.value - targets[r.stimulus][r.question]) for r in answers.where(condition="none")]]
    )
    assert overall[0]["mean"] == pytest.approx(none.mean())
    assert overall[0]["se_as_printed"] == pytest.approx(none.std(ddof=1) / np.sqrt(len(none)))


def test_errors_that_do_not_differ_are_not_shown_to():
    answers, targets = scores({"none": 1.2, "5,000": 1.2}, seed=2)
    found = only(analyse(answers, plan=AnalysisPlan({"rating": 0.3}, targets=targets, draws=100)))
    assert finding(found, "none minus 5,000", "Wilcoxon", "confirmatory").verdict in (EQUIVALENT, UNDECIDED)
    loose = only(analyse(answers, plan=AnalysisPlan({"rating": 1.0}, targets=targets, draws=100)))
    assert finding(loose, "none minus 5,000", "Wilcoxon", "confirmatory").verdict == EQUIVALENT


def test_a_condition_can_be_what_the_others_are_held_against():
    answers, _ = scores({"plates": 0.5, "a": 0.6, "b": 2.0})
    section = only(analyse(answers, plan=AnalysisPlan({}, reference="plates", draws=100)))
    assert finding(section, "a minus b", "Wilcoxon").verdict == SHOWN
    with pytest.raises(DataError, match="one of the conditions plates, a, b"):
        analyse(answers, plan=AnalysisPlan({}, reference="sensor", draws=100))
    with pytest.raises(DataError, match="must have a score of 'plate0' for 'rough'"):
        analyse(answers, plan=AnalysisPlan({}, targets={"other": {}}, draws=100))


def test_evoked_shares_have_intervals_and_holm():
    rng = np.random.default_rng(0)
    truth = {"i1": 0.95, "i2": 0.5, "i3": 0.05}
    rows = [
        (p, k + 1, {"stimulus": image, "value": float(rng.random() < share)})
        for p in range(30)
        for k, (image, share) in enumerate(truth.items())
    ]
    section = only(analyse(simulated("evoked", "rough", rows)))
    table = {row["image"]: row for row in section.tables["per image and word"]}
    assert [table[image]["verdict"] for image in truth] == [SHOWN, NOT_SHOWN, SHOWN]
    assert all(table[i]["wilson_low"] < share < table[i]["wilson_high"] for i, share in truth.items())
    assert table["i1"]["n"] == 30


def staircase(people=4, threshold=-18.0, seed=0, trials=50):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        x, run, own = 0.0, 0, threshold + 2 * rng.standard_normal()
        for t in range(trials):
            right = bool(rng.random() < 0.5 + 0.5 / (1 + np.exp(-(x - own))))
            rows.append((p, t + 1, {"condition": "tone", "stimulus": "tone", "value": x, "correct": right}))
            run = run + 1 if right else 0
            if not right or run == 3:
                x, run = x + (-4.0 if right else 4.0), 0
    return simulated("staircase", "which", rows)


def test_the_threshold_that_was_put_in_is_found():
    section = only(analyse(staircase(), plan=AnalysisPlan({}, draws=100)))
    [by_reversals] = section.role("confirmatory")
    settled = -18 + np.log((0.5 ** (1 / 3) - 0.5) / (1 - 0.5 ** (1 / 3)))
    assert by_reversals.low < settled < by_reversals.high
    assert [f.test for f in section.role("as printed")] == []


def test_the_last_reversal_counts_though_nothing_follows_it():
    values, right = [0, 0, 0, -4, 0, 0, 0, -4], [1, 1, 1, 0, 1, 1, 1, 0]
    rows = [
        (0, t + 1, {"value": float(v), "correct": bool(r)})
        for t, (v, r) in enumerate(zip(values, right, strict=True))
    ]
    own = simulated("staircase", "which", rows)
    assert np.flatnonzero(reversals_of(own)).tolist() == [3, 6, 7]
    assert np.flatnonzero(reversals_of(Answers(own.rows[:7]))).tolist() == [3, 6]
    assert np.flatnonzero(reversals_of(Answers(own.rows[:6]))).tolist() == [3]


def flattened(rows):
    """Return estimates that do not grow with intensity."""
    rng = np.random.default_rng(1)
    noise = np.exp(0.05 * rng.standard_normal(len(rows)))
    return simulated(
        "magnitude",
        "magnitude",
        [(p, t, {**columns, "value": float(v)}) for (p, t, columns), v in zip(rows, noise, strict=True)],
    )


def test_stevens_exponent_is_found_whatever_numbers_people_choose():
    rng = np.random.default_rng(0)
    rows = []
    for p in range(8):
        scale, own = np.exp(3 * rng.standard_normal()), 0.6 + 0.05 * rng.standard_normal()
        for t, x in enumerate([0.1, 0.2, 0.4, 0.8] * 2):
            value = float(scale * x**own * np.exp(0.1 * rng.standard_normal()))
            rows.append((p, t + 1, {"stimulus": f"s{x}", "level": f"gain={x}", "value": value}))
    section = only(analyse(simulated("magnitude", "magnitude", rows)))
    [exponent] = section.role("confirmatory")
    assert exponent.low < 0.6 < exponent.high
    assert exponent.margin is None
    flat = only(analyse(flattened(rows), plan=AnalysisPlan({"magnitude": 0.1}))).role("confirmatory")
    assert [one.verdict for one in flat] == [EQUIVALENT]
    means = [row["geometric_mean"] for row in section.tables["geometric means"]]
    assert means[3] / means[0] == pytest.approx(8**0.6, rel=0.15)


def pairs(strengths, people=10, seed=0):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        t = 0
        for a in range(len(strengths)):
            for b in range(a + 1, len(strengths)):
                for _ in range(3):
                    t += 1
                    first = float(rng.random() < 1 / (1 + np.exp(strengths[b] - strengths[a])))
                    rows.append((p, t, {"stimulus": f"s{a}", "other": f"s{b}", "value": first}))
    return simulated("pairwise", "preferred", rows)


def test_what_is_preferred_is_shown_and_what_is_not_is_not():
    section = only(analyse(pairs([1.5, 0.0, 0.0]), plan=AnalysisPlan({}, draws=400)))
    verdicts = {f.of: f.verdict for f in section.role("confirmatory")}
    assert verdicts == {"s0 over s1": SHOWN, "s0 over s2": SHOWN, "s1 over s2": NOT_SHOWN}
    assert (
        finding(section, "s0 over s1", "Bradley-Terry").low
        < 1.5
        < finding(section, "s0 over s1", "Bradley-Terry").high
    )


def test_preferences_that_are_as_good_as_equal_take_a_margin():
    answers = pairs([0.0, 0.0], people=40, seed=1)
    wide, narrow = (
        only(analyse(answers, plan=AnalysisPlan({"preference": margin}, draws=400))).role("confirmatory")[0]
        for margin in (1.0, 0.05)
    )
    assert (wide.verdict, narrow.verdict) == (EQUIVALENT, UNDECIDED)
    assert wide.margin == 1.0
    shown = only(analyse(pairs([1.5, 0.0]), plan=AnalysisPlan({"preference": 0.4}, draws=400))).role(
        "confirmatory"
    )
    assert shown[0].verdict == SHOWN


def test_strengths_are_those_of_the_choices_and_stay_finite():
    wins = np.array([[0, 30, 40], [10, 0, 25], [5, 15, 0]], float)
    strengths = bradley_terry(wins, prior_sd=100)
    expected = 1 / (1 + np.exp(strengths[None, :] - strengths[:, None]))
    total = wins + wins.T
    assert (expected * total).sum(1) - np.diag(expected * total) == pytest.approx(wins.sum(1), abs=1e-2)
    assert np.isfinite(bradley_terry(np.array([[0, 9], [0, 0]], float))).all()


@pytest.mark.parametrize(
    "answers",
    [
        which(people=3, trials=6),
        realism(people=3, marks=6),
        scores({"a": 1.0, "b": 1.5}, people=3)[0],
        pairs([1, 0], people=3),
    ],
    ids=["which", "realism", "rating", "pairwise"],
)
def test_an_analysis_is_json_text_and_figures_that_say_simulated(answers):
    found = analyse(
        answers, plan=AnalysisPlan({}, draws=100 if answers.rows[0].design != "pairwise" else 400)
    )
    plain = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert plain["simulated"] is True
    assert "simulated participants" in found.text()
    for section in found.sections:
        for figure in find_design(section.design).figures(section, answers).values():
            figure.draw_without_rendering()
            said = [axes.get_title() for axes in figure.axes] + [figure.get_suptitle()]
            assert any("simulated participants" in title for title in said)


def changed(answers, **values):
    return Answers(tuple(replace(row, **values) for row in answers))


TWO = which(people=2)


@pytest.mark.parametrize(
    ("answers", "words"),
    [
        (Answers(), "must hold trials"),
        (changed(TWO, design="maze"), "design must be one of"),
        (Answers((*TWO, *TWO)), "appears twice"),
        (Answers((*TWO, *changed(TWO, study="other"))), "of one study"),
        (Answers((*TWO, *changed(TWO, simulated=False))), "simulated participants and of people"),
        (changed(realism(people=2), value=float("nan")), "answer with a number"),
    ],
)
def test_answers_that_cannot_be_analysed_are_refused_in_a_line(answers, words):
    with pytest.raises(DataError, match=words):
        analyse(answers)


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        ({"margins": {"speed": 1.0}}, "a margin must be for one of"),
        ({"margins": {"which": 0.0}}, "must be > 0"),
        ({"margins": {}, "targets": {}, "reference": "a"}, "got both"),
        ({"margins": {}, "draws": 10}, "draws must be at least 100"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(plan, words):
    with pytest.raises(ParameterError, match=words):
        analyse(Answers(TWO), plan=AnalysisPlan(**plan))
