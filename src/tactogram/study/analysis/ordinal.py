"""Ordinal analysis of word scores, whose steps need not be equal, as a check of the means."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy import stats
from threadpoolctl import threadpool_limits

from tactogram.study.analysis.findings import Finding
from tactogram.study.answers import Answers


def ordinal_findings(answers: Answers, conditions: Sequence[str]) -> list[Finding]:
    """Return, per word, the shift of scores with the condition: a proportional-odds model against the first condition.

    P. McCullagh, J. R. Stat. Soc. B 42 (1980), by statsmodels' ``OrderedModel``. The estimate is the log odds of a
    higher score; its error is by participant (sandwich over participants, t with participants - 1 degrees of freedom).
    """
    findings = []
    for word, group in answers.by("question").items():
        for other in conditions[1:]:
            pair = group.where(condition=(conditions[0], other))
            finding = _shift(word, conditions[0], other, pair)
            if finding is not None:
                findings.append(finding)
    return findings


def _shift(word: str, first: str, second: str, pair: Answers) -> Finding | None:
    from statsmodels.miscmodels.ordinal_model import OrderedModel

    people = pair.unique("participant")
    x = np.array([float(row.condition == second) for row in pair])
    if len(people) < 3 or x.min() == x.max() or len(set(pair.column("value"))) < 2:
        return None
    place = {name: number for number, name in enumerate(people)}
    who = np.array([place[name] for name in pair.column("participant")])
    scores = pd.Series(pd.Categorical(pair.numbers(), ordered=True))
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")
        model = OrderedModel(scores, x[:, None], distr="logit")
        fit = model.fit(method="bfgs", disp=False)
        scored = model.score_obs(np.asarray(fit.params))
        bread = np.linalg.pinv(-model.hessian(np.asarray(fit.params)))
    clusters = np.zeros((len(people), scored.shape[1]))
    np.add.at(clusters, who, scored)
    correction = len(people) / (len(people) - 1)
    se = float(np.sqrt(correction * (bread @ clusters.T @ clusters @ bread)[0, 0]))
    estimate, df = float(np.asarray(fit.params)[0]), len(people) - 1
    if not (np.isfinite(se) and se > 0):
        return None
    half = float(stats.t.isf(0.025, df)) * se
    p = float(2 * stats.t.sf(abs(estimate) / se, df))
    return Finding(
        f"{word}, {second} against {first}",
        "proportional odds by participant, uncorrected",
        "check",
        "log odds of a higher score",
        estimate,
        estimate - half,
        estimate + half,
        p,
        n=len(pair),
        participants=len(people),
        statistic=estimate / se,
    )
