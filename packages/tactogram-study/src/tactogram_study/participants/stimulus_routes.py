"""Routes for the stimuli of a participant's current page: sounds, pictures, the server's display, and the finger."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Query, Response, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from tactogram.errors import ParameterError, TactogramError
from tactogram_study.participants.bodies import (
    EmptyRequest,
    FingerMessage,
    FingerStatus,
    PageToken,
    PlayRequest,
    PlayResponse,
    SlotName,
    StopResponse,
)
from tactogram_study.participants.prepared_stimuli import wav_bytes
from tactogram_study.participants.refusals import (
    CANNOT_PLAY,
    PROGRAM_ERROR,
    PROGRAM_STATUS,
    OutdatedPageError,
    StimulusPlaybackError,
    status_of,
)
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
from tactogram_study.workflows.streams import FingerStream

log = logging.getLogger("tactogram_studio")


def add_stimulus_routes(router: APIRouter, sessions: SessionRegistry) -> None:
    """Add ``sound``, ``image``, ``play`` and ``stop`` under ``/take/TICKET``."""

    @router.get(
        "/take/{ticket}/sound", response_class=Response, responses=_file("audio/wav", "32-bit floats")
    )
    async def sound(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return the sound of a slot of the current page, and log it as played."""
        result = await anyio.to_thread.run_sync(sound_of, ticket, token, slot, limiter=sessions.making)
        session, code, wav, played = result
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
    async def image(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return the picture of a slot of the current page."""
        return await anyio.to_thread.run_sync(image_of, ticket, token, slot, limiter=sessions.making)

    def image_of(ticket: str, token: str, slot: str) -> Response:
        session, _, page = current_page(sessions, ticket, token, slot)
        stimulus = page.slot(slot).stimulus
        if stimulus is None or not stimulus.is_seen:
            raise ParameterError(f"slot {slot!r} shows no picture")
        with anonymous_failure(session):
            return Response(session.stimuli.picture(stimulus), media_type="image/png")

    @router.post("/take/{ticket}/play")
    def play(ticket: str, body: PlayRequest) -> PlayResponse:
        """Play a slot of the current page on the server's display; responds when it has ended."""
        session, code, page = current_page(sessions, ticket, body.token, body.slot)
        if session.study.played_by != "server":
            raise ParameterError("this study does not play on request; get sound, or send the finger")
        with anonymous_failure(session):
            drive, played = session.stimuli.drive(page, body.slot)
            display = session.stimuli.display(page.slot(body.slot).stimulus)
        log_slot_played(session, code, body.token, body.slot, played)
        with anonymous_failure(session):
            facts = sessions.display.play(ticket, drive, display)
        return PlayResponse(state=facts["state"], simulated_device=facts["simulated_device"])

    @router.post("/take/{ticket}/stop")
    def stop(ticket: str, body: EmptyRequest) -> StopResponse:
        """Fade out this participant's stimulus."""
        sessions.state_of(ticket)
        return StopResponse(stopped=sessions.display.stop(ticket))


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
        return session.store.log_played(code, token, slot, **played.logged)
    except UnknownParticipantError:  # withdrawn meanwhile
        raise UnknownSessionError(NO_TICKET) from None
    except PageNotOpenError as error:  # answered meanwhile
        raise OutdatedPageError from error


NOT_UNDERSTOOD, REFUSED = 1003, 1008
"""Codes that close a websocket (RFC 6455, 7.4.1)."""


def add_finger_route(router: APIRouter, sessions: SessionRegistry) -> None:
    """Add ``finger`` under ``/take/TICKET``."""

    @router.websocket("/take/{ticket}/finger")
    async def finger(socket: WebSocket, ticket: str, token: Annotated[PageToken, Query()]) -> None:
        """Stream the slot that the finger is on, until it leaves it, the page or the study."""
        entry = await anyio.to_thread.run_sync(sessions.by_ticket, ticket)
        if entry is None:
            await socket.close(REFUSED)
            return
        await socket.accept()
        slots = _StreamedSlots(socket, sessions, ticket, token)
        try:
            while True:
                message = FingerMessage.model_validate_json(await socket.receive_text())
                await slots.move(message)
        except ValidationError:
            with suppress(RuntimeError):
                await socket.close(NOT_UNDERSTOOD)
        except (WebSocketDisconnect, KeyError):  # closed, or not a text
            pass
        finally:
            await slots.leave()


class _StreamedSlots:
    """The slot of a page that is being streamed, one at a time."""

    def __init__(self, socket: WebSocket, sessions: SessionRegistry, ticket: str, token: str) -> None:
        self._socket, self._sessions, self._ticket, self._token = socket, sessions, ticket, token
        self._slot: str | None = None
        self._failed = False
        self._stream: FingerStream | None = None
        self._task: asyncio.Task[None] | None = None

    async def move(self, message: FingerMessage) -> None:
        """Take positions on a slot; a touch of another one, or after an end, starts its stream.

        What failed is tried again once the finger was lifted.
        """
        touches = any(sample[3] for sample in message.samples)
        if not touches or message.slot != self._slot:
            self._failed = False
        over = self._task is None or self._task.done()
        if touches and not self._failed and (message.slot != self._slot or over):
            await self.leave()
            self._slot = message.slot
            await self._begin(message.slot)
        if self._stream is not None:
            self._stream.add(message.samples)

    async def leave(self) -> None:
        """End the stream and wait until the display is at rest and the facts are logged."""
        if self._stream is not None:
            self._stream.stop()
        if self._task is not None:
            with suppress(asyncio.CancelledError):
                await asyncio.shield(self._task)
        self._slot = self._stream = self._task = None

    async def _begin(self, slot: SlotName) -> None:
        try:
            session, row, stream = await anyio.to_thread.run_sync(self._prepared, slot, time.perf_counter())
        except TactogramError as error:
            await self._fail(slot, str(error), status_of(error))
            return
        self._stream = stream
        self._task = asyncio.create_task(self._play(session, slot, row, stream))

    def _prepared(self, slot: SlotName, landed_s: float) -> tuple[OpenSession, int, FingerStream]:
        session, code, page = current_page(self._sessions, self._ticket, self._token, slot)
        if session.study.played_by != "stream":
            raise ParameterError("this study does not follow the finger; get sound, or send play")
        with anonymous_failure(session):
            stream, played = session.stimuli.stream(page, slot, landed_s=landed_s)
        return session, log_slot_played(session, code, self._token, slot, played), stream

    async def _play(self, session: OpenSession, slot: SlotName, row: int, stream: FingerStream) -> None:
        loop = asyncio.get_running_loop()

        def began() -> None:
            asyncio.run_coroutine_threadsafe(self._tell(FingerStatus(slot=slot, state="playing")), loop)

        def play() -> None:
            with anonymous_failure(session):
                facts = self._sessions.display.stream(self._ticket, stream, began=began)
            session.store.complete_played(row, facts)

        try:
            await anyio.to_thread.run_sync(play)
        except TactogramError as error:
            await self._fail(slot, str(error), status_of(error))
        except Exception:
            log.exception("%s: a stream could not be logged", session.name)
            await self._fail(slot, PROGRAM_ERROR, PROGRAM_STATUS)
        else:
            await self._tell(FingerStatus(slot=slot, state="ended"))

    async def _fail(self, slot: SlotName, error: str, status: int) -> None:
        self._failed = True
        await self._tell(FingerStatus(slot=slot, state="failed", error=error, status=status))

    async def _tell(self, status: FingerStatus) -> None:
        with suppress(RuntimeError, WebSocketDisconnect):  # the page is gone
            await self._socket.send_text(status.model_dump_json())
