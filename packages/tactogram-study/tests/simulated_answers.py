"""Answers of simulated participants, and what an analysis finds in them."""

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
