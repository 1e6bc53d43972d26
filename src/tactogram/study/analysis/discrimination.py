"""Discrimination: shares correct of answers that are right or wrong, pooled by participant and by texture.

Ten trials cannot show that two stimuli are indistinguishable: 9 of 10 must be right for a share to differ from chance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import stats

from tactogram.statistics.clustered import PooledShare, pooled_share
from tactogram.statistics.equivalence import share_equivalence
from tactogram.statistics.mixed_share import mixed_share
from tactogram.statistics.multiplicity import holm
from tactogram.statistics.shares import corrected, share_of, smallest_significant
from tactogram.study.analysis.exact import exact_finding
from tactogram.study.analysis.findings import AnalysisSection, Finding, answered, section_of, verdict_of
from tactogram.study.answers import Answers

CORRECT = "share correct"


def analyse_discrimination(
    answers: Answers,
    *,
    title: str,
    d_prime: Callable[[float], float],
    margin: float | None = None,
    printed: bool = False,
) -> AnalysisSection:
    """Return the analysis of answers that are right or wrong, where chance is one half.

    Confirmatory is the share over all textures, by GEE with participants as clusters; of a single participant the
    exact binomial of that person's answers.

    Parameters
    ----------
    answers : Answers
        One row per trial of one question; ``correct``, else ``value`` as 1 or 0.
    title : str
    d_prime : callable
        From a share correct to d'.
    margin : float, optional
        Of the share correct, e.g. 0.1, given before the answers were seen.
    printed : bool
        Whether a publication printed the mean share without a test.

    Raises
    ------
    DataError
        If no answer is right or wrong.
    ParameterError
        If the margin is not between 0 and 0.5.
    """
    kept, notes = answered(_marked(answers), title)
    hits = kept.numbers("value")
    people, textures = kept.column("participant"), kept.column("stimulus")
    findings = [
        _overall(hits, people, margin, d_prime),
        _as_printed(hits, people, printed),
        *_mixed(hits, people, textures),
    ]
    per_texture, rows = _textures(kept, margin, d_prime)
    findings += per_texture + _sides(kept)
    few = min(row["n"] for row in rows)
    needed = smallest_significant(few)
    notes += (
        "exact binomial tests per texture take answers as independent, which those of one person are not; "
        "the share by participant does not",
        f"of {few} answers "
        + (f"{needed} must be right" if needed else "not even all being right would be enough")
        + " for p < .05",
    )
    return section_of(
        kept,
        title,
        findings,
        {"share correct per texture": rows},
        notes,
        question=kept.rows[0].question or "which",
    )


def _marked(answers: Answers) -> Answers:
    """Return the answers with 1 or 0 as value, from ``correct`` where that is given."""
    if all(row.correct is None for row in answers):
        return answers
    rows = [
        row if row.correct is None else Answers((row,)).changed(value=float(row.correct)).rows[0]
        for row in answers
    ]
    return Answers(tuple(rows))


def _overall(
    hits: Any, people: tuple[str, ...], margin: float | None, d_prime: Callable[[float], float]
) -> Finding:
    if len(set(people)) > 1:
        return _pooled(pooled_share(hits, people, margin=margin), "all", margin, d_prime, "confirmatory")
    share = share_of(int(hits.sum()), len(hits))
    equal = None if margin is None else share_equivalence(share.count, share.n, margin=margin).p
    return exact_finding(
        "all",
        share,
        CORRECT,
        role="confirmatory",
        participants=1,
        effect={"d'": d_prime(corrected(share.count, share.n))},
        equivalence_p=equal,
        margin=margin,
        note="one participant: this says nothing of other people",
    )


def _pooled(
    found: PooledShare,
    of: str,
    margin: float | None,
    d_prime: Callable[[float], float],
    role: Any,
    p: float | None = None,
    correction: str = "none",
) -> Finding:
    p = found.p if p is None else p
    return Finding(
        of,
        "GEE by participant",
        role,
        CORRECT,
        found.share,
        found.low,
        found.high,
        p,
        verdict_of(p, equivalence_p=found.equivalence_p),
        found.n,
        found.participants,
        found.statistic,
        {"d'": d_prime(corrected(round(found.share * found.n), found.n))},
        found.equivalence_p,
        margin,
        correction,
        found.note,
    )


def _as_printed(hits: Any, people: tuple[str, ...], printed: bool) -> Finding:
    share = share_of(int(hits.sum()), len(hits))
    return exact_finding(
        "all",
        share,
        CORRECT,
        test="mean share held against 50 %, answers taken as independent",
        role="as printed" if printed else "check",
        participants=len(set(people)),
        note="the publication printed no test: p is that of the exact binomial" if printed else "",
    )


def _mixed(hits: Any, people: tuple[str, ...], textures: tuple[str, ...]) -> list[Finding]:
    if len(set(people)) < 2 or hits.min() == hits.max():
        return []
    found = mixed_share(hits, {"participant": people, "texture": textures})
    shown = "" if found.low <= 0.5 <= found.high else "shown"
    return [
        Finding(
            "all",
            "binomial mixed model, participants and textures at random",
            "check",
            CORRECT,
            found.estimate,
            found.low,
            found.high,
            verdict=shown or "not shown",
            n=len(hits),
            participants=len(set(people)),
            note="; ".join(["of a typical participant and texture", *([found.note] if found.note else [])]),
        )
    ]


def _textures(
    kept: Answers, margin: float | None, d_prime: Callable[[float], float]
) -> tuple[list[Finding], list[dict[str, Any]]]:
    """Return each texture's findings, p by Holm over the textures, and the table of their shares."""
    groups = kept.by("stimulus")
    exact = {name: share_of(int(g.numbers().sum()), len(g)) for name, g in groups.items()}
    exact_holm = holm([share.p for share in exact.values()])
    equals = {
        name: share_equivalence(share.count, share.n, margin=margin).p
        for name, share in exact.items()
        if margin is not None
    }
    equals = dict(zip(equals, holm(list(equals.values())), strict=True))
    clustered = {
        name: pooled_share(g.numbers(), g.column("participant"), margin=margin)
        for name, g in groups.items()
        if len(set(g.column("participant"))) > 1
    }
    ps = dict(zip(clustered, holm([found.p for found in clustered.values()]), strict=True))
    if margin is not None:
        within = holm([found.equivalence_p or 0.0 for found in clustered.values()])
        clustered = {
            name: replace(found, equivalence_p=p)
            for (name, found), p in zip(clustered.items(), within, strict=True)
        }
    findings, rows = [], []
    for (name, share), p in zip(exact.items(), exact_holm, strict=True):
        equal = equals.get(name)
        people = len(set(groups[name].column("participant")))
        effect = d_prime(corrected(share.count, share.n))
        findings.append(
            exact_finding(
                name,
                share,
                CORRECT,
                p=p,
                participants=people,
                effect={"d'": effect},
                equivalence_p=equal,
                margin=margin,
                correction="Holm",
            )
        )
        if name in clustered and len(groups) > 1:
            findings.append(_pooled(clustered[name], name, margin, d_prime, "check", ps[name], "Holm"))
        means = [g.numbers().mean() for g in groups[name].by("participant").values()]
        rows.append(
            {
                "texture": name,
                "correct": share.count,
                "n": share.n,
                "participants": people,
                "share": share.share,
                "wilson_low": share.wilson[0],
                "wilson_high": share.wilson[1],
                "clopper_pearson_low": share.clopper_pearson[0],
                "clopper_pearson_high": share.clopper_pearson[1],
                "participants_mean": float(np.mean(means)),
                "participants_se": float(stats.sem(means)) if len(means) > 1 else None,
                "d_prime": effect,
                "p_exact": share.p,
                "p_by_participant": clustered[name].p if name in clustered else None,
                "verdict": findings[-1].verdict,
            }
        )
    return findings, rows


def _sides(kept: Answers) -> list[Finding]:
    """Return whether one side is answered more often, whatever is there: a bias that d' does not need to have."""
    sided = kept.where(answer=("A", "B"))
    if len(set(sided.column("participant"))) < 2:
        return []
    found = pooled_share(
        np.array([float(a == "A") for a in sided.column("answer")]), sided.column("participant")
    )
    return [
        Finding(
            "side",
            "GEE by participant",
            "check",
            "share answered A",
            found.share,
            found.low,
            found.high,
            found.p,
            verdict_of(found.p),
            found.n,
            found.participants,
            note="a preference for one side, whatever was there",
        )
    ]
