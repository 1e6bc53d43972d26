"""One participant's way through a study: consent, questions, practice, trials, questions, end.

All of it is a pure function of the study, the participant and the answers so far.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from tactogram.study.answers import Answer
from tactogram.study.practice import MARK, TOKEN, practice_answers
from tactogram.study.questions import AnswerOption, Question
from tactogram.study.session.device_facts import device_columns
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PageAnswers, PageQuestion, Participant
from tactogram.study.wording import Wording

CONSENT, BEFORE, AFTER = "consent", "before", "after"
"""Tokens of the pages around the trials."""
AGREE = Question(
    id="consent",
    text=Wording(ja="参加に同意しますか。", en="Do you agree to take part?"),
    kind="choice",
    options=(
        AnswerOption(value="agreed", text=Wording(ja="同意する", en="I agree")),
        AnswerOption(value="declined", text=Wording(ja="同意しない", en="I do not agree")),
    ),
)


def next_page(study: Study, participant: Participant, given: Sequence[PageAnswers]) -> Page | None:
    """Return the page after ``given``, all that the participant answered so far in order; None at the end.

    Parameters
    ----------
    study : Study
    participant : Participant
    given : sequence of Given
    """
    tokens = [one.token for one in given]
    if CONSENT not in tokens:
        consent = {"consent_sha256": consent_sha256(study)}
        return Page(CONSENT, "consent", (PageQuestion(AGREE),), text=study.consent, more=consent)
    if declined(given):
        return None
    if study.before and BEFORE not in tokens:
        return Page(BEFORE, "questions", tuple(PageQuestion(question) for question in study.before))
    practice = practice_answers(given)
    trials = [
        one for one in given if one.token not in (CONSENT, BEFORE, AFTER) and not one.token.startswith(TOKEN)
    ]
    if study.practice is not None and not trials:
        page = study.practice.next_page(study.design, study.setting, participant, practice)
        if page is not None:
            return page
    page = study.design.next_page(study.setting, participant, trials)
    if page is not None and study.practice is not None and not trials:
        return study.practice.first_trial(page, study.design, study.setting, participant, practice)
    if page is not None:
        due = study.rest_every and page.trial > 1 and page.step == 1
        return replace(page, rest=bool(due and (page.trial - 1) % study.rest_every == 0))
    if study.after and AFTER not in tokens:
        return Page(AFTER, "questions", tuple(PageQuestion(question) for question in study.after))
    return None


def declined(given: Sequence[PageAnswers]) -> bool:
    """Return whether the participant did not agree to take part."""
    return any(one.token == CONSENT and one.responses.get("consent") != "agreed" for one in given)


def consent_sha256(study: Study) -> str:
    """Return the hash of the text that was agreed to, in all languages."""
    return hashlib.sha256(study.consent.model_dump_json().encode()).hexdigest()


def answer_rows(
    study: Study,
    participant: Participant,
    page: Page,
    responses: Mapping[str, str],
    *,
    at: str,
    rt_ms: Mapping[str, float] | None = None,
    played: Mapping[str, str] | None = None,
    device: Mapping[str, Any] | None = None,
) -> tuple[Answer, ...]:
    """Return the rows that the accepted answers to a page make.

    Parameters
    ----------
    responses : mapping from str to str
        What `Page.accepted` returned.
    at : str
        ISO time, UTC.
    rt_ms : mapping from str to float, optional
        By key; ``""`` stands for the page.
    played : mapping from str to str, optional
        Hash of what was played, by slot.
    device : mapping, optional
        What `device_facts.kept_facts` kept.
    """
    columns = device_columns(device or {})
    times, hashes = rt_ms or {}, played or {}
    return tuple(
        Answer(
            study=study.name,
            participant=participant.code,
            session=participant.session,
            block=page.block,
            trial=page.trial,
            repeat=page.repeat,
            design=_design(page),
            question=asked.question.id,
            condition=asked.condition,
            stimulus=asked.stimulus,
            other=asked.other,
            side=asked.side,
            answer=responses[asked.key],
            value=value_of(asked, responses[asked.key]),
            correct=responses[asked.key] == asked.right if asked.right else None,
            scale_low=_scale(asked)[0],
            scale_high=_scale(asked)[1],
            rt_ms=times.get(asked.key, times.get("", math.nan)),
            at=at,
            played_sha256=_played(asked, hashes),
            level=_level(study, page),
            display=_display(study, page),
            seed=study.seed,
            simulated=participant.simulated,
            more=_further(page, asked) | columns,
        )
        for asked in page.asked
    )


def value_of(asked: PageQuestion, answer: str) -> float:
    """Return the number that an answer stands for, NaN if none."""
    if answer in asked.values:
        return asked.values[answer]
    if asked.question.kind in ("steps", "vas", "number") and answer:
        return float(answer)
    return math.nan


def _scale(asked: PageQuestion) -> tuple[float, float]:
    """Return the ends of the scale that was offered; of a choice between no and yes, 0 and 1."""
    if asked.values and not asked.right and len(set(asked.values.values())) == 2:
        return min(asked.values.values()), max(asked.values.values())
    return asked.question.low, asked.question.high


def _played(asked: PageQuestion, hashes: Mapping[str, str]) -> str:
    if asked.slot:
        return hashes.get(asked.slot, "")
    return "+".join(hashes[slot] for slot in ("", "A", "B", "X") if hashes.get(slot))


def _level(study: Study, page: Page) -> str:
    levels = [p.stimulus.level or study.level for p in page.presented if p.stimulus and p.stimulus.is_played]
    return "+".join(dict.fromkeys(levels))


def _display(study: Study, page: Page) -> str:
    shown = [
        p.stimulus.display or study.display for p in page.presented if p.stimulus and p.stimulus.is_played
    ]
    return "+".join(dict.fromkeys(shown))


def _design(page: Page) -> str:
    if page.practice:
        return MARK
    return "questions" if page.kind == "consent" else page.kind


def _further(page: Page, asked: PageQuestion) -> dict[str, str]:
    simulated = any(p.stimulus is not None and p.stimulus.is_simulated for p in page.presented)
    return {
        "token": page.token,
        "step": str(page.step),
        **({"other_condition": asked.other_condition} if asked.other else {}),
        **({MARK: page.kind} if page.practice else {}),
        **({"simulated_stimuli": "true"} if simulated else {}),
        **page.more,
    }
