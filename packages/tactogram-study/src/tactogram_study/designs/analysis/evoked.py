"""Analysis of evoked words: shares of participants, by image and word."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tactogram.statistics import INK, holm, krippendorff_alpha
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import (
    SHOWN,
    AnalysisSection,
    Finding,
    estimate_finding,
    exact_finding,
    numeric_answers,
    section_of,
    share_columns,
    verdict_of,
)
from tactogram_study.analysis.paired import item_contrasts
from tactogram_study.answers import Answers
from tactogram_study.statistics import pooled_share, share_of

EVOKED = "share of participants in whom it was evoked"


def analyse_evoked(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return the share of participants in whom each image evoked each word, with intervals.

    The publication took the share as the label of an image, without an interval. Confirmatory is the exact binomial of
    each image and word against one half (evoked in most, or in few), with Holm's correction over all: a participant
    answers each once, so that answers are independent. A check compares the share of words that each image evokes with
    the other images that the same people saw; the margin is that of this difference. Raises `DataError` if no answer is
    a number.
    """
    kept, notes = numeric_answers(answers, "evoked")
    cells = {
        # One vote per participant: the majority of several answers, a tie as not evoked.
        (image, word): [int(mean > 0.5) for mean in group.participant_means()[()]]
        for word, of_word in kept.by("question").items()
        for image, group in of_word.by("stimulus").items()
    }
    shares = {key: share_of(sum(votes), len(votes)) for key, votes in cells.items()}
    ps = holm([share.p for share in shares.values()])
    findings, rows = [], []
    for ((image, word), share), p in zip(shares.items(), ps, strict=True):
        facts = {"image": image, "word": word, "evoked": share.count, "n": share.n}
        rows.append(facts | share_columns(share) | {"p_holm": p, "verdict": verdict_of(p)})
        findings.append(
            exact_finding(
                f"{image}, {word}",
                share,
                EVOKED,
                role="confirmatory",
                p=p,
                participants=share.n,
                correction="Holm over images and words",
            )
        )
    rows.sort(key=lambda row: (row["image"], row["word"]))
    words, per_word = _words(kept)
    smallest = min(share.n for share in shares.values())
    low, high = share_of(smallest // 2, smallest).wilson
    notes += (
        "shown means: more or fewer than half of all people would say so, not that the share is near 0 or 1",
        f"with {smallest} participants an interval at one half is ±{(high - low) / 2:.2f}: "
        "labels are that far from certain",
    )
    if len(kept.unique("condition")) > 1:
        notes += ("the conditions of an image are taken together",)
    contrasts = item_contrasts(kept, "difference of the share evoked", margin=margin)
    findings += [*words, *contrasts]
    tables = {"per word": per_word, "per image and word": rows}
    return section_of(kept, "Evoked or not", findings, tables, notes, question="evoked")


def _words(kept: Answers) -> tuple[list[Finding], list[dict[str, Any]]]:
    """Return each word's share over images by participant, and the participants' agreement."""
    findings, rows = [], []
    for word, group in kept.by("question").items():
        if group.people < 2:
            continue
        estimate = pooled_share(group.numbers(), group.column("participant"))
        images = {name: k for k, name in enumerate(group.unique("stimulus"))}
        raters = {name: k for k, name in enumerate(group.unique("participant"))}
        table = np.full((len(images), len(raters)), np.nan)
        for row in group:
            table[images[row.stimulus], raters[row.participant]] = row.value
        alpha = krippendorff_alpha(table, level="nominal") if len(images) > 1 else None
        rows.append(
            {
                "word": word,
                "share": estimate.estimate,
                "low": estimate.low,
                "high": estimate.high,
                "participants": group.people,
                "krippendorff_alpha": alpha,
            }
        )
        findings.append(
            estimate_finding(
                word,
                "GEE by participant, over all images",
                "share evoked",
                estimate,
                group,
                p=None,
                statistic=None,
            )
        )
    return findings, rows


def evoked_figure(section: AnalysisSection) -> Figure:
    """Draw the share of participants in whom each image evoked each word, dots where most or few is shown."""
    rows = section.tables["per image and word"]
    images = list(dict.fromkeys(str(row["image"]) for row in rows))
    words = list(dict.fromkeys(str(row["word"]) for row in rows))
    table = np.full((len(words), len(images)), np.nan)
    sure = np.zeros(table.shape, bool)
    for row in rows:
        cell = words.index(row["word"]), images.index(row["image"])
        table[cell], sure[cell] = row["share"], row["verdict"] == SHOWN
    figure = Figure(
        figsize=(min(15.0, 3.2 + 0.13 * max(len(images), 24)), 1.7 + 0.3 * len(words)), layout="constrained"
    )
    axes = figure.add_subplot()
    picture = axes.imshow(table, cmap="RdBu_r", vmin=0, vmax=1, aspect="auto")
    down, across = np.nonzero(sure)
    axes.plot(across, down, ".", color=INK, ms=3)
    figure.colorbar(picture, ax=axes, pad=0.01, label="share evoked")
    axes.set_yticks(range(len(words)), words)
    every = max(1, len(images) // 40)
    axes.set_xticks(range(0, len(images), every), images[::every], rotation=90, fontsize=6)
    axes.set_title(f"{title_of(section)}\ndots: more or fewer than half is shown (Holm)", fontsize=10)
    return figure
