"""Request and response bodies of participants' pages, as typed JSON."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from tactogram.validation import FrozenModel
from tactogram_study.wording import Language

Text = Annotated[str, Field(max_length=4000)]
Key = Annotated[str, Field(max_length=200)]
PageToken = Annotated[str, Field(min_length=1, max_length=200)]
SlotName = Literal["", "A", "B", "X"]
Device = Annotated[dict[str, Any], Field(max_length=100)]
"""Facts that a device reports; the store drops those that it cannot keep."""


class RequestBody(FrozenModel):
    """Body of a request. Unknown keys are refused."""


class JoinRequest(RequestBody):
    """Request to join as a new participant, or to continue with a code."""

    code: Annotated[str, Field(max_length=40)] = ""
    """Empty for a new participant."""
    language: Language
    device: Device = Field(default_factory=dict)
    attempt: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{0,64}$")] = ""
    """Random text from the page: the same attempt sent twice makes one participant."""


class AnswersRequest(RequestBody):
    """Answers to a page."""

    token: PageToken
    answers: Annotated[dict[Key, Text], Field(max_length=500)]
    rt_ms: Annotated[dict[Key, float], Field(max_length=500)] = Field(default_factory=dict)
    """By key of a question; "" is the page."""
    device: Device = Field(default_factory=dict)


class PlayRequest(RequestBody):
    """Request to play a stimulus on the server's display."""

    token: PageToken
    slot: SlotName = ""


class FingerMessage(RequestBody):
    """Positions of a finger on a slot of the current page: (time in ms, x and y in mm, 1 while it touches) each."""

    slot: SlotName
    samples: Annotated[list[tuple[float, float, float, float]], Field(max_length=500)]


class FingerStatus(BaseModel):
    """State of a slot's stream; if it failed, the error, and the status that a request would have been refused with."""

    slot: SlotName
    state: Literal["playing", "ended", "failed"]
    error: str = ""
    status: int = 0


class LanguageRequest(RequestBody):
    """Request to switch the language."""

    language: Language


class EmptyRequest(RequestBody):
    """An empty object."""


class JoinResponse(BaseModel):
    """The participant who joined."""

    ticket: str
    code: str


class OfferResponse(BaseModel):
    """Information shown before joining."""

    title: dict[str, str]
    languages: list[str]
    open: bool


class PageResponse(BaseModel):
    """Participant's current page."""

    page: dict[str, Any] | None
    """`tactogram_study.trials.Page.shown`; null at the end."""
    title: str
    languages: list[str]
    language: str
    code: str
    played_by: str
    progress: dict[str, int]
    """``trial`` and ``of``."""
    state: Literal["going", "done", "declined", "aborted"]


class AnswersResponse(PageResponse):
    """Participant's page after sending answers."""

    stored: bool
    """False if the page was answered before: nothing changed."""


class PlayResponse(BaseModel):
    """Result of a request to play."""

    state: Literal["ended", "stopped"]
    simulated_device: bool


class StopResponse(BaseModel):
    """Response to stop: true if something was playing."""

    stopped: bool


class ErrorResponse(BaseModel):
    """Reason for a refusal, in one sentence."""

    error: str
