"""Images and the words they evoke: shares of participants, per image and word."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.statistics.clustered import pooled_share
from tactogram.statistics.comparison import friedman_wilcoxon
from tactogram.statistics.multiplicity import holm
from tactogram.statistics.reliability import krippendorff_alpha
from tactogram.statistics.shares import ShareEstimate, share_of
from tactogram.study.analysis.exact import exact_finding
from tactogram.study.analysis.findings import AnalysisSection, Finding, answered, section_of, verdict_of
from tactogram.study.analysis.item_contrasts import item_contrasts
from tactogram.study.analysis.paired import paired_findings
from tactogram.study.answers import Answers

EVOKED = "share of participants in whom it was evoked"


def analyse_evoked(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return the share of participants in whom each image evoked each word, with intervals.

    The publication took the share as the label of an image, without an interval. Confirmatory is the exact binomial of
    each image and word against one half (evoked in most, or in few), with Holm's correction over all: a participant
    answers once to each, so that answers are independent. Beside it the share of words that each image evokes, held
    against the other images that the same people saw.

    Parameters
    ----------
    answers : Answers
    margin : float, optional
        Of an image's share of words to that of the others, given before the answers were seen.

    Raises
    ------
    DataError
        If no answer is a number.
    """
    kept, notes = answered(answers, "evoked")
    cells = {
        (image, word): once
        for word, of_word in kept.by("question").items()
        for image, group in of_word.by("stimulus").items()
        for once in [_once(group)]
    }
    shares = {key: share_of(sum(votes.values()), len(votes)) for key, votes in cells.items()}
    ps = holm([share.p for share in shares.values()])
    rows = [_row(image, word, share, p) for ((image, word), share), p in zip(shares.items(), ps, strict=True)]
    findings = [
        exact_finding(
            f"{image}, {word}",
            share,
            EVOKED,
            role="confirmatory",
            p=p,
            participants=share.n,
            correction="Holm over images and words",
        )
        for ((image, word), share), p in zip(shares.items(), ps, strict=True)
    ]
    rows.sort(key=lambda row: (row["image"], row["word"]))
    words, per_word = _words(kept)
    notes += (
        "shown means: more or fewer than half of all people would say so, not that the share is near 0 or 1",
    )
    smallest = min(share.n for share in shares.values())
    notes += (
        f"with {smallest} participants an interval at one half is ±{_half_width(smallest):.2f}: "
        "labels are that far from certain",
    )
    contrasts = item_contrasts(kept, "difference of the share evoked", margin=margin)
    findings += [*words, *_conditions(kept), *contrasts]
    tables = {"per word": per_word, "per image and word": rows}
    return section_of(kept, "Evoked or not", findings, tables, notes, question="evoked")


def _once(group: Answers) -> dict[str, int]:
    """Return one vote per participant: of several the majority, a tie as not evoked."""
    return {person: int(np.mean(own.numbers()) > 0.5) for person, own in group.by("participant").items()}


def _half_width(n: int) -> float:
    low, high = share_of(n // 2, n).wilson
    return (high - low) / 2


def _row(image: str, word: str, share: ShareEstimate, p: float) -> dict[str, Any]:
    return {
        "image": image,
        "word": word,
        "evoked": share.count,
        "n": share.n,
        "share": share.share,
        "wilson_low": share.wilson[0],
        "wilson_high": share.wilson[1],
        "clopper_pearson_low": share.clopper_pearson[0],
        "clopper_pearson_high": share.clopper_pearson[1],
        "p_holm": p,
        "verdict": verdict_of(p),
    }


def _words(kept: Answers) -> tuple[list[Finding], list[dict[str, Any]]]:
    """Return each word's share over images by participant, and how far people agree."""
    findings, rows = [], []
    for word, group in kept.by("question").items():
        people = group.column("participant")
        if len(set(people)) < 2:
            continue
        found = pooled_share(group.numbers(), people)
        images = {name: k for k, name in enumerate(group.unique("stimulus"))}
        raters = {name: k for k, name in enumerate(dict.fromkeys(people))}
        table = np.full((len(images), len(raters)), np.nan)
        for row in group:
            table[images[row.stimulus], raters[row.participant]] = row.value
        alpha = krippendorff_alpha(table, level="nominal") if len(images) > 1 else None
        rows.append(
            {
                "word": word,
                "share": found.share,
                "low": found.low,
                "high": found.high,
                "participants": found.participants,
                "krippendorff_alpha": alpha,
            }
        )
        findings.append(
            Finding(
                word,
                "GEE by participant, over all images",
                "check",
                "share evoked",
                found.share,
                found.low,
                found.high,
                n=found.n,
                participants=found.participants,
                note=found.note,
            )
        )
    return findings, rows


def _conditions(kept: Answers) -> list[Finding]:
    """Return whether conditions that the same people met evoke more, by participant."""
    groups = kept.by("condition")
    people = kept.unique("participant")
    means = {
        name: np.array([_mean(group.where(participant=person)) for person in people])
        for name, group in groups.items()
    }
    if len(means) < 2 or (~np.isnan(np.stack(list(means.values()))).any(0)).sum() < 2:
        return []
    findings = []
    found = friedman_wilcoxon(means)
    for pair in found.pairs:
        gaps = means[pair.first] - means[pair.second]
        findings += paired_findings(
            gaps[~np.isnan(gaps)],
            f"{pair.first} minus {pair.second}",
            "difference of the share evoked",
            n=len(groups[pair.first]) + len(groups[pair.second]),
        )
    return findings


def _mean(answers: Answers) -> float:
    return float(np.mean(answers.numbers())) if len(answers) else float("nan")
