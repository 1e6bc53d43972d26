"""Discrimination: shares correct, pooled by participant and by texture.

Ten trials cannot show that two stimuli are indistinguishable: 9 of 10 must be right for a share to differ from chance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import stats

from tactogram.statistics import holm
from tactogram_study.analysis.findings import (
    BY_P,
    AnalysisSection,
    Finding,
    Role,
    estimate_finding,
    exact_finding,
    numeric_answers,
    section_of,
    share_columns,
)
from tactogram_study.answers import Answers
from tactogram_study.planned import ALPHA
from tactogram_study.statistics import (
    corrected,
    pooled_share,
    share_equivalence,
    share_of,
    smallest_significant,
)

CORRECT = "share correct"
DPrime = Callable[[float], float]


def analyse_discrimination(
    answers: Answers,
    *,
    title: str,
    d_prime: DPrime,
    margin: float | None = None,
    alpha: float = ALPHA,
    printed: bool = False,
) -> AnalysisSection:
    """Return the analysis of answers that are right or wrong, where chance is one half.

    Confirmatory is the share over all textures, by GEE with participants as clusters; of a single participant the exact
    binomial of that person's answers.

    Parameters
    ----------
    answers : Answers
        One row per trial of one question; ``correct``, else ``value`` as 1 or 0.
    d_prime : callable
        From a share correct to d'.
    margin : float, optional
        Of the share correct, e.g. 0.1, set before the answers were seen.
    alpha : float
        A person whose own p is below it is not at chance.
    printed : bool
        Whether a publication printed the mean share without a test.
    """
    marked = [row if row.correct is None else replace(row, value=float(row.correct)) for row in answers]
    kept, notes = numeric_answers(Answers(tuple(marked)), title)
    hits = kept.numbers()
    share = share_of(int(hits.sum()), len(hits))
    findings = [
        _overall(kept, margin, d_prime),
        exact_finding(
            "all",
            share,
            CORRECT,
            test="mean share held against 50 %, answers taken as independent",
            role="as printed" if printed else "check",
            participants=kept.people,
            note="the publication printed no test: p is that of the exact binomial" if printed else "",
        ),
    ]
    per_texture, rows = _textures(kept, margin, d_prime, alpha)
    findings += per_texture + _sides(kept)
    few = min(row["n"] for row in rows)
    needed = smallest_significant(few)
    notes += (
        "exact binomial tests per texture take answers as independent, which those of one person are not; "
        "the share by participant does not",
        f"of {few} answers "
        + (f"{needed} must be right" if needed else "not even all being right would be enough")
        + " for p < .05",
        "at chance: people whose own share for the texture does not differ from one half, by the exact binomial test, "
        f"two-sided, p >= {alpha:g}, uncorrected",
    )
    return section_of(
        kept,
        title,
        findings,
        {"share correct per texture": rows},
        notes,
        question=kept.rows[0].question or "which",
    )


def _overall(kept: Answers, margin: float | None, d_prime: DPrime) -> Finding:
    if kept.people > 1:
        return _pooled(kept, "all", margin, d_prime, role="confirmatory")
    share = share_of(int(kept.numbers().sum()), len(kept))
    return exact_finding(
        "all",
        share,
        CORRECT,
        role="confirmatory",
        participants=1,
        effect={"d'": d_prime(corrected(share.count, share.n))},
        equivalence_p=None if margin is None else share_equivalence(share.count, share.n, margin=margin),
        margin=margin,
        note="one participant: this says nothing of other people",
    )


def _pooled(
    answers: Answers, of: str, margin: float | None, d_prime: DPrime, *, role: Role = "check"
) -> Finding:
    """Return the share by participant, with p and equivalence uncorrected."""
    n = len(answers)
    estimate = pooled_share(answers.numbers(), answers.column("participant"), margin=margin)
    return estimate_finding(
        of,
        "GEE by participant",
        CORRECT,
        estimate,
        answers,
        role=role,
        effect={"d'": d_prime(corrected(round(estimate.estimate * n), n))},
        margin=margin,
    )


def _textures(
    kept: Answers, margin: float | None, d_prime: DPrime, alpha: float
) -> tuple[list[Finding], list[dict[str, Any]]]:
    """Return each texture's findings, p by Holm over the textures, and the table of their shares."""
    groups = kept.by("stimulus")
    shares = {name: share_of(int(g.numbers().sum()), len(g)) for name, g in groups.items()}
    equal: dict[str, float] = {}
    if margin is not None:
        equal = {name: share_equivalence(hits.count, hits.n, margin=margin) for name, hits in shares.items()}
    ps = _holm({name: share.p for name, share in shares.items()})
    equals = _holm(equal)
    pooled = {name: _pooled(g, name, margin, d_prime) for name, g in groups.items() if g.people > 1}
    pooled_ps = _holm({name: finding.p or 0.0 for name, finding in pooled.items()})
    pooled_equals = _holm(
        {name: finding.equivalence_p or 0.0 for name, finding in pooled.items() if margin is not None}
    )
    findings, rows = [], []
    for name, share in shares.items():
        effect = d_prime(corrected(share.count, share.n))
        finding = exact_finding(
            name,
            share,
            CORRECT,
            p=ps[name],
            participants=groups[name].people,
            effect={"d'": effect},
            equivalence_p=equals.get(name),
            margin=margin,
            correction="Holm",
        )
        findings.append(finding)
        if name in pooled and len(groups) > 1:
            finding = replace(
                pooled[name],
                p=pooled_ps[name],
                equivalence_p=pooled_equals.get(name),
                verdict=BY_P,
                correction="Holm",
            )
            findings.append(finding)
        means = groups[name].participant_means()[()]
        rows.append(
            {
                "texture": name,
                "correct": share.count,
                "n": share.n,
                "participants": groups[name].people,
                "at_chance": _at_chance(groups[name], alpha),
                **share_columns(share),
                "participants_mean": float(np.mean(means)),
                "participants_se": float(stats.sem(means)) if len(means) > 1 else None,
                "d_prime": effect,
                "p_exact": share.p,
                "p_by_participant": (pooled[name].p or 0.0) if name in pooled else None,
                "verdict": finding.verdict,
            }
        )
    return findings, rows


def _holm(ps: Mapping[str, float]) -> dict[str, float]:
    """Return p by name, with Holm's correction over all."""
    return dict(zip(ps, holm([*ps.values()]), strict=True))


def _at_chance(answers: Answers, alpha: float) -> str:
    """Return how many people's own shares do not differ from one half, such as "7 of 10"."""
    hits = [person.numbers() for person in answers.by("participant").values()]
    at_chance = sum(share_of(int(own.sum()), len(own)).p >= alpha for own in hits)
    return f"{at_chance} of {len(hits)}"


def _sides(kept: Answers) -> list[Finding]:
    """Return whether one side is answered more often, whatever is presented there: a bias that d' need not have."""
    sided = kept.where(answer=("A", "B"))
    if sided.people < 2:
        return []
    estimate = pooled_share([answer == "A" for answer in sided.column("answer")], sided.column("participant"))
    return [
        estimate_finding(
            "side",
            "GEE by participant",
            "share answered A",
            estimate,
            sided,
            statistic=None,
            note="a preference for one side, whatever was there",
        )
    ]
