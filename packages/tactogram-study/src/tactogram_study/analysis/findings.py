"""Findings of an analysis, with interval and verdict, and the sections that hold them.

A large p never becomes "no difference". A difference is *shown*, or *not shown*; with a margin set beforehand, what is
not shown is *equivalent within the margin* or *undecided*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from tactogram.errors import DataError
from tactogram.text_files import finite_json
from tactogram_study.planned import ALPHA

if TYPE_CHECKING:
    from tactogram_study.answers import Answers
    from tactogram_study.statistics import EffectEstimate, ShareEstimate

Role = Literal["confirmatory", "as printed", "check"]
HEADINGS: Mapping[Role, str] = {
    "confirmatory": "Confirmatory",
    "as printed": "As printed in the publication",
    "check": "Checks",
}
SHOWN, NOT_SHOWN = "shown", "not shown"
EQUIVALENT, UNDECIDED = "equivalent within the margin", "undecided"
VERDICTS = (SHOWN, NOT_SHOWN, EQUIVALENT, UNDECIDED)
BY_P = "by p"
SMALL = "the difference is shown, and is smaller than the margin"
MOST_LINES = 120
"""Findings of one role that a text lists; more are counted there, and listed in the JSON only."""


@dataclass(frozen=True)
class Finding:
    """Result of one test or estimate.

    Parameters
    ----------
    of : str
        A texture, a word, two conditions; ``all`` for all together.
    role : {"confirmatory", "as printed", "check"}
        Whether it decides, repeats the publication's analysis, or checks the former.
    measure : str
        Quantity of the estimate, with its unit.
    low, high : float or None
        Interval of 95 %.
    p : float or None
        Two-sided; corrected as ``correction`` names.
    verdict : str
        `SHOWN`, `NOT_SHOWN`, `EQUIVALENT` or `UNDECIDED`; by default that of p, empty without one.
    n, participants : int
        Answers, and people.
    effect : mapping from str to float
        Sizes such as Cohen's dz and d'.
    """

    of: str
    test: str
    role: Role
    measure: str
    estimate: float
    low: float | None = None
    high: float | None = None
    p: float | None = None
    verdict: str = BY_P
    n: int = 0
    participants: int = 0
    statistic: float | None = None
    effect: Mapping[str, float] = field(default_factory=dict)
    equivalence_p: float | None = None
    margin: float | None = None
    correction: str = "none"
    note: str = ""

    def __post_init__(self) -> None:
        if self.verdict == BY_P:
            object.__setattr__(self, "verdict", verdict_of(self.p, equivalence_p=self.equivalence_p))

    def p_text(self) -> str:
        """Return p with its correction as text, "" without one."""
        correction = "" if self.correction == "none" else f" ({self.correction})"
        return "" if self.p is None else p_text(self.p) + correction

    def within(self) -> str:
        """Return the margin and the p of equivalence as text, "" without one."""
        if self.margin is None or self.equivalence_p is None:
            return ""
        return f"±{number(self.margin)}: {p_text(self.equivalence_p)}"

    def text(self) -> str:
        """Return the finding in one line."""
        parts = [f"{self.measure} {number(self.estimate)}"]
        if self.low is not None and self.high is not None:
            parts[0] += f" (95 %: {number(self.low)} to {number(self.high)})"
        parts += [self.p_text()] if self.p is not None else []
        parts += [f"{name} {number(value)}" for name, value in self.effect.items()]
        parts += [f"within {within}"] if (within := self.within()) else []
        line = f"{self.of}: {self.test}: {', '.join(parts)}"
        line += f"; {self.verdict}" if self.verdict else ""
        return line + (f" [{self.note}]" if self.note else "")


@dataclass(frozen=True)
class AnalysisSection:
    """Results for one question of a study; ``tables`` are rows by the table's name."""

    title: str
    design: str
    question: str
    participants: int
    answers: int
    simulated: bool
    findings: tuple[Finding, ...]
    tables: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def role(self, role: Role) -> list[Finding]:
        """Return the findings of one role."""
        return [finding for finding in self.findings if finding.role == role]

    def as_dict(self) -> dict[str, Any]:
        """Return the section as plain values for JSON, with null for what is not finite."""
        rows = {name: [dict(row) for row in rows] for name, rows in self.tables.items()}
        facts = {**vars(self), "findings": [dict(vars(f)) for f in self.findings], "tables": rows}
        plain: dict[str, Any] = finite_json(facts)
        return plain

    def text(self) -> str:
        """Return the section in lines, confirmatory findings first."""
        who = "simulated participants" if self.simulated else "participants"
        lines = [self.title, f"{self.answers} answers of {self.participants} {who}"]
        for role, heading in HEADINGS.items():
            findings = self.role(role)
            if len(findings) > MOST_LINES:
                counts = ", ".join(f"{sum(f.verdict == v for f in findings)} {v}" for v in VERDICTS)
                lines += ["", f"{heading}: {len(findings)} findings ({counts}), all in the JSON"]
            elif findings:
                lines += ["", f"{heading}:", *(f"  {finding.text()}" for finding in findings)]
        for name, rows in self.tables.items():
            lines += ["", f"{name}:", *(f"  {line}" for line in table_lines(rows))]
        if self.notes:
            lines += ["", *(f"Note: {note}." for note in self.notes)]
        return "\n".join(lines)


def estimate_finding(
    of: str,
    test: str,
    measure: str,
    found: EffectEstimate,
    answers: Answers,
    *,
    role: Role = "check",
    **more: Any,
) -> Finding:
    """Return the finding of an estimate from answers, with interval, p and note; ``more`` replaces its other values."""
    values = {
        "n": len(answers),
        "participants": answers.people,
        "p": found.p,
        "statistic": found.statistic,
        "equivalence_p": found.equivalence_p,
        "note": found.note,
    }
    estimate = (found.estimate, found.low, found.high)
    return Finding(of, test, role, measure, *estimate, **(values | more))


def section_of(
    kept: Answers,
    title: str,
    findings: Sequence[Finding],
    tables: Mapping[str, Sequence[Mapping[str, Any]]],
    notes: Sequence[str] = (),
    *,
    question: str = "",
) -> AnalysisSection:
    """Return the section of the analysed answers to one question, at least one; ``question`` is theirs by default."""
    return AnalysisSection(
        title,
        kept.rows[0].design,
        question or kept.rows[0].question,
        kept.people,
        len(kept),
        any(kept.column("simulated")),
        tuple(findings),
        tables,
        tuple(notes),
    )


def verdict_of(p: float | None, *, equivalence_p: float | None = None, alpha: float = ALPHA) -> str:
    """Return the verdict of a test and, with a margin, of the test of equivalence.

    A difference that is both shown and within the margin counts as shown: it is small.
    """
    if p is not None and p < alpha:
        return SHOWN
    if equivalence_p is None:
        return "" if p is None else NOT_SHOWN
    return EQUIVALENT if equivalence_p < alpha else UNDECIDED


def with_verdicts(section: AnalysisSection, *, alpha: float = ALPHA, note: str = "") -> AnalysisSection:
    """Return a section with its verdicts at ``alpha``, and ``note`` on each finding with a margin.

    A finding with an interval of 95 % but no p has no verdict at another alpha.
    """
    findings = tuple(_with_verdict(finding, alpha, note) for finding in section.findings)
    last = {finding.of: finding.verdict for finding in findings}
    tables = {
        name: [
            {**row, "verdict": _row_verdict(row, last, alpha)} if "verdict" in row else row for row in rows
        ]
        for name, rows in section.tables.items()
    }
    return replace(section, findings=findings, tables=tables)


def _row_verdict(row: Mapping[str, Any], last: Mapping[str, str], alpha: float) -> str:
    """Return the verdict of a table's row by its p, or that of the last finding about its texture."""
    if "p_holm" in row:
        return verdict_of(row["p_holm"], alpha=alpha)
    return last.get(str(row.get("texture")), str(row["verdict"]))


def _with_verdict(finding: Finding, alpha: float, note: str) -> Finding:
    if finding.p is None:
        return finding if alpha == ALPHA else replace(finding, verdict="")
    if not finding.verdict:
        return finding
    equal = finding.equivalence_p
    verdict = verdict_of(finding.p, equivalence_p=equal, alpha=alpha)
    small = verdict == SHOWN and equal is not None and equal < alpha
    notes = [finding.note, SMALL if small else "", note if equal is not None else ""]
    return replace(finding, verdict=verdict, note="; ".join(filter(None, notes)))


def numeric_answers(answers: Answers, what: str) -> tuple[Answers, tuple[str, ...]]:
    """Return the answers with a number, and a note of how many lack one; raise `DataError` if all do."""
    kept = answers.where(lambda row: math.isfinite(row.value))
    if not len(kept):
        raise DataError(what, "must have an answer with a number in the column value, got none")
    missing = len(answers) - len(kept)
    return kept, (f"{missing} answers without a number are left out",) if missing else ()


def table_lines(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return rows as aligned columns below their headings."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    grid = [names, *([_cell(row.get(name)) for name in names] for row in rows)]
    widths = [max(len(line[k]) for line in grid) for k in range(len(names))]
    return ["  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in grid]


def number(value: float) -> str:
    """Return a number as text: three decimals below ten, two digits below a hundredth."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "infinite" if value > 0 else "-infinite"
    if 0 < abs(value) < 0.01:
        return f"{value:.2g}"
    return f"{value:.3f}" if abs(value) < 10 else f"{value:.1f}"


def p_text(p: float) -> str:
    """Return a p-value as text."""
    return "p < .0001" if p < 1e-4 else f"p = {p:.4f}".replace("0.", ".", 1)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return number(value) if isinstance(value, float) else str(value)


def exact_finding(
    of: str,
    share: ShareEstimate,
    measure: str,
    *,
    participants: int,
    role: Role = "check",
    test: str = "exact binomial, interval by Wilson",
    p: float | None = None,
    **more: Any,
) -> Finding:
    """Return the finding of a share tested against one half, with Wilson's interval.

    ``p`` replaces the share's own after a correction; ``more`` are further values of the `Finding`.
    """
    estimate = (share.share, *share.wilson, share.p if p is None else p)
    return Finding(of, test, role, measure, *estimate, n=share.n, participants=participants, **more)


def share_columns(share: ShareEstimate) -> dict[str, float]:
    """Return the columns of a table with a share and its intervals."""
    wilson, clopper_pearson = share.wilson, share.clopper_pearson
    return {
        "share": share.share,
        "wilson_low": wilson[0],
        "wilson_high": wilson[1],
        "clopper_pearson_low": clopper_pearson[0],
        "clopper_pearson_high": clopper_pearson[1],
    }
