"""Which of a pair is preferred: strengths by R. A. Bradley, M. E. Terry, Biometrika 39 (1952), by participant."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

from tactogram.errors import DataError
from tactogram.statistics.clustered import bootstrap_by_participant
from tactogram.statistics.shares import share_of
from tactogram.study.analysis.finding import Finding, Section, answered, holm, verdict_of
from tactogram.study.answers import Answer, Answers

Numbers = NDArray[np.float64]
PRIOR_SD = 3.0
"""Of log strengths: keeps those of what always wins finite, and moves others little (a factor of 20 is one SD)."""


def bradley_terry(wins: Numbers, *, prior_sd: float = PRIOR_SD) -> Numbers:
    """Return log strengths of items: P(i over j) = 1 / (1 + exp(s_j - s_i)).

    Maximum likelihood with a weak normal prior.

    Parameters
    ----------
    wins : float64 array, shape (item, item)
        How often the row's was preferred to the column's.
    prior_sd : float

    Returns
    -------
    float64 array, shape (item,)
        Their mean is 0.
    """
    count = len(wins)

    def loss(s: Numbers) -> tuple[float, Numbers]:
        gaps = s[:, None] - s[None, :]
        won = special.expit(-gaps) * wins
        value = float((wins * np.logaddexp(0, -gaps)).sum() + (s**2).sum() / (2 * prior_sd**2))
        return value, won.sum(0) - won.sum(1) + s / prior_sd**2

    found = optimize.minimize(loss, np.zeros(count), jac=True, method="L-BFGS-B").x
    return np.asarray(found - found.mean())


def analyse_preference(
    answers: Answers, *, rng: np.random.Generator, margin: float | None = None, draws: int = 500
) -> Section:
    """Return the strength of each item, and of every two whether one is preferred.

    Confirmatory are the differences of strengths, each with an interval by participants drawn with replacement and
    Holm's correction over all pairs; with two items this is the share that prefers the first.

    Parameters
    ----------
    answers : Answers
        ``stimulus`` (with ``condition``) and ``other`` (with ``other_condition``) are the pair; ``value`` is 1 where
        ``stimulus`` was preferred, 0 where ``other`` was, 0.5 for a tie.
    rng : numpy Generator
    margin : float, optional
        Of a difference of log strengths, given before the answers were seen: 0.4 is 60 % who prefer the first.
    draws : int

    Raises
    ------
    DataError
        If an answer is none of these, or there are fewer than two items, or a pair is of one item.
    """
    kept, notes = answered(answers, "pairwise")
    pairs = [(_item(row.stimulus, row.condition), _item(row.other, _other(row))) for row in kept]
    items = tuple(dict.fromkeys(name for pair in pairs for name in pair))
    if len(items) < 2 or any(a == b for a, b in pairs):
        raise DataError(f"pairwise: must be pairs of two items, got {', '.join(items)}")
    if any(value not in (0.0, 0.5, 1.0) for value in kept.numbers()):
        raise DataError(
            "pairwise: value must be 1 (stimulus preferred), 0 (other) or 0.5, got another number"
        )
    people = kept.unique("participant")
    table = np.zeros((len(people), len(items), len(items)))
    for row, (first, second) in zip(kept, pairs, strict=True):
        who, a, b = people.index(row.participant), items.index(first), items.index(second)
        table[who, a, b] += row.value
        table[who, b, a] += 1 - row.value
    strengths, low, high, drawn = _strengths(table, rng, draws)
    rows = _rows(items, table.sum(0), strengths, low, high)
    findings = _pairs(items, table, strengths, drawn, margin)
    if len(people) == 1:
        notes += ("one participant: no interval over people",)
    if not _connected(table.sum(0)):
        notes += (
            "some items were never compared, not even through others: their strengths rest on the prior",
        )
    transitive = _circular(table)
    notes += (
        f"strengths have a weak prior (SD {PRIOR_SD:g}), so that what always wins stays finite",
        f"{transitive} circular triads in participants' own choices: what no order of strengths explains",
    )
    return Section(
        "Preference",
        kept.rows[0].design,
        kept.rows[0].question,
        len(people),
        len(kept),
        any(kept.column("simulated")),
        tuple(findings),
        {"strengths (log, mean 0)": rows},
        notes,
    )


def _item(stimulus: str, condition: str) -> str:
    return f"{stimulus} ({condition})" if condition else stimulus


def _other(row: Answer) -> str:
    return row.more.get("other_condition", row.condition if row.other != row.stimulus else "")


def _strengths(
    table: Numbers, rng: np.random.Generator, draws: int
) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    drawn: list[Numbers] = []

    def of(some: Numbers) -> Numbers:
        found = bradley_terry(some.sum(0))
        drawn.append(found)
        return found

    strengths, low, high = bootstrap_by_participant(table, of, rng=rng, draws=draws)
    return strengths, low, high, np.array(drawn[1:])


def _rows(
    items: Sequence[str], wins: Numbers, strengths: Numbers, low: Numbers, high: Numbers
) -> list[dict[str, Any]]:
    order = np.argsort(-strengths, kind="stable")
    return [
        {
            "item": items[k],
            "strength": float(strengths[k]),
            "low": float(low[k]),
            "high": float(high[k]),
            "preferred": float(wins[k].sum()),
            "of": float(wins[k].sum() + wins[:, k].sum()),
        }
        for k in order
    ]


def _pairs(
    items: Sequence[str], table: Numbers, strengths: Numbers, drawn: Numbers, margin: float | None
) -> list[Finding]:
    """Return every two items: the difference of strengths, and the exact binomial of their own comparisons."""
    names = list(combinations(range(len(items)), 2))
    wins, people = table.sum(0), len(table)
    gaps = {pair: strengths[pair[0]] - strengths[pair[1]] for pair in names}
    ps: dict[tuple[int, int], float] = {}
    equals: dict[tuple[int, int], float] = {}
    if people > 1:
        for a, b in names:
            # Normal, with the bootstrap's spread and t of the participants: percentiles cannot go below 1 / draws.
            se = float((drawn[:, a] - drawn[:, b]).std(ddof=1)) * np.sqrt(people / (people - 1))
            ps[a, b] = float(2 * stats.t.sf(abs(gaps[a, b]) / max(se, 1e-12), people - 1))
            if margin is not None:
                equals[a, b] = float(stats.t.sf((margin - abs(gaps[a, b])) / max(se, 1e-12), people - 1))
    corrected = dict(zip(ps, holm(list(ps.values())), strict=True))
    equals = dict(zip(equals, holm(list(equals.values())), strict=True))
    findings = []
    for a, b in names:
        name = f"{items[a]} over {items[b]}"
        ends = np.quantile(drawn[:, a] - drawn[:, b], [0.025, 0.975]) if people > 1 else None
        p = corrected[a, b] if ps else None
        findings.append(
            Finding(
                name,
                "Bradley-Terry, bootstrap by participant",
                "confirmatory",
                "difference of log strengths",
                float(gaps[a, b]),
                None if ends is None else float(ends[0]),
                None if ends is None else float(ends[1]),
                p,
                verdict_of(p, equivalence_p=equals.get((a, b))),
                int(wins.sum()),
                people,
                effect={"P(first preferred)": float(special.expit(gaps[a, b]))},
                equivalence_p=equals.get((a, b)),
                margin=margin if equals else None,
                correction="Holm",
            )
        )
        direct = int(wins[a, b] + wins[b, a])
        if direct:
            share = share_of(int(np.floor(wins[a, b])), direct)
            findings.append(
                Finding(
                    name,
                    "exact binomial of this pair alone, uncorrected",
                    "check",
                    "share preferring the first",
                    share.share,
                    *share.wilson,
                    share.p,
                    verdict_of(share.p),
                    direct,
                    people,
                    note="takes answers as independent",
                )
            )
    return findings


def _connected(wins: Numbers) -> bool:
    from scipy.sparse.csgraph import connected_components

    return bool(connected_components(wins + wins.T, directed=False)[0] == 1)


def _circular(table: Numbers) -> int:
    """Return the circular triads (a over b over c over a) among each participant's majorities."""
    beats = (table > table.transpose(0, 2, 1)).astype(np.float64)
    return round(float(np.einsum("pij,pjk,pki->", beats, beats, beats)) / 3)
