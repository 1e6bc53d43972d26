"""Routes for the stimuli of a participant's current page: sounds, pictures, and playing on the server's display."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Query, Response

from tactogram.errors import ParameterError, TactogramError
from tactogram_study.participants.bodies import (
    EmptyRequest,
    PageToken,
    PlayRequest,
    PlayResponse,
    SlotName,
    StopResponse,
)
from tactogram_study.participants.prepared_stimuli import wav_bytes
from tactogram_study.participants.refusals import CANNOT_PLAY, OutdatedPageError, StimulusPlaybackError
from tactogram_study.participants.server_display import DisplayInUseError
from tactogram_study.participants.sessions import (
    NO_TICKET,
    OpenSession,
    SessionRegistry,
    UnknownSessionError,
)
from tactogram_study.session.participants import PageNotOpenError, UnknownParticipantError
from tactogram_study.trials import Page
from tactogram_study.workflows.stimuli import SlotPlayback

log = logging.getLogger("tactogram_studio")


def add_stimulus_routes(router: APIRouter, sessions: SessionRegistry) -> None:
    """Add ``sound``, ``image``, ``play`` and ``stop`` under ``/take/TICKET``."""

    @router.get(
        "/take/{ticket}/sound", response_class=Response, responses=_file("audio/wav", "32-bit floats")
    )
    async def sound(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return the sound of a slot of the current page, and log it as played."""
        made = await anyio.to_thread.run_sync(sound_of, ticket, token, slot)
        session, code, wav, played = made
        await anyio.to_thread.run_sync(
            log_slot_played, session, code, token, slot, played, limiter=session.writing
        )
        # Without hash or level: they would reveal in words what participants are to judge by touch.
        return Response(wav, media_type="audio/wav")

    def sound_of(ticket: str, token: str, slot: str) -> tuple[OpenSession, str, bytes, SlotPlayback]:
        session, code, page = current_page(sessions, ticket, token, slot)
        if session.study.played_by != "browser":
            raise ParameterError("this study plays on the server; send play, or the finger")
        with anonymous_failure(session):
            drive, played = session.stimuli.drive(page, slot)
            return session, code, wav_bytes(drive), played

    @router.get("/take/{ticket}/image", response_class=Response, responses=_file("image/png", "a picture"))
    def image(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return the picture of a slot of the current page."""
        session, _, page = current_page(sessions, ticket, token, slot)
        stimulus = page.slot(slot).stimulus
        if stimulus is None or not stimulus.is_seen:
            raise ParameterError(f"slot {slot!r} shows no picture")
        with anonymous_failure(session):
            return Response(session.stimuli.picture(page, slot), media_type="image/png")

    @router.post("/take/{ticket}/play")
    def play(ticket: str, body: PlayRequest) -> PlayResponse:
        """Play a slot of the current page on the server's display; responds when it has ended."""
        session, code, page = current_page(sessions, ticket, body.token, body.slot)
        if session.study.played_by != "server":
            raise ParameterError("this study does not play on request; get sound, or send the finger")
        with anonymous_failure(session):
            drive, played = session.stimuli.drive(page, body.slot)
            display = session.stimuli.display(page.slot(body.slot))
        log_slot_played(session, code, body.token, body.slot, played)
        with anonymous_failure(session):
            facts = sessions.display.play(ticket, drive, display)
        return PlayResponse(state=facts["state"], simulated_device=facts["simulated_device"])

    @router.post("/take/{ticket}/stop")
    def stop(ticket: str, body: EmptyRequest) -> StopResponse:
        """Fade out this participant's stimulus."""
        sessions.state_of(ticket)
        return StopResponse(stopped=sessions.display.stop(ticket))


def streams_only(session: OpenSession) -> None:
    """Refuse a study that does not stream."""
    if session.study.played_by != "stream":
        raise ParameterError("this study does not follow the finger; get sound, or send play")


def _file(kind: str, description: str) -> dict[int | str, dict[str, Any]]:
    return {200: {"content": {kind: {}}, "description": description}}


def current_page(
    sessions: SessionRegistry, ticket: str, token: str, slot: str
) -> tuple[OpenSession, str, Page]:
    """Return a participant's session, code and current page, if it is the token's page and has the slot."""
    session, state = sessions.state_of(ticket)
    page = state.page
    if page is None or page.token != token:
        raise OutdatedPageError
    page.slot(slot)
    return session, state.participant.code, page


@contextmanager
def anonymous_failure(session: OpenSession) -> Iterator[None]:
    """Raise for participants only that a stimulus failed; which one is logged and shown to the experimenter."""
    try:
        yield
    except DisplayInUseError:
        raise
    except Exception as error:
        if isinstance(error, TactogramError):
            log.warning("%s: %s", session.name, error)
        else:
            log.exception("%s: a stimulus failed", session.name)
        failures = session.stimuli.failures
        if str(error) not in failures.values():
            failures[""] = " ".join(str(error).split())[:300] or type(error).__name__
        raise StimulusPlaybackError(CANNOT_PLAY) from error


def log_slot_played(session: OpenSession, code: str, token: str, slot: str, played: SlotPlayback) -> int:
    """Log what is played in a slot and return the log's row; a participant or page that is gone is refused."""
    try:
        return session.store.log_played(
            code,
            token,
            slot,
            sha256=played.sha256,
            level=played.level,
            display=played.display,
            gain_db=played.gain_db,
        )
    except UnknownParticipantError:  # withdrawn meanwhile
        raise UnknownSessionError(NO_TICKET) from None
    except PageNotOpenError as error:  # answered meanwhile
        raise OutdatedPageError from error
