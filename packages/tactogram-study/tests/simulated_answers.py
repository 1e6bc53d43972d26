"""Answers of simulated participants, and what an analysis finds in them."""

import numpy as np

from tactogram_study.answers import Answer, Answers

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


def only(analysis):
    [section] = analysis.sections
    return section


def finding(section, of, test, role=None):
    return next(
        f for f in section.findings if f.of == of and f.test.startswith(test) and role in (None, f.role)
    )


def which(people=10, trials=60, logit=0.0, sd=0.4, seed=0, design="two_area"):
    """Return right and wrong answers of people whose true shares scatter about that of ``logit``."""
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
