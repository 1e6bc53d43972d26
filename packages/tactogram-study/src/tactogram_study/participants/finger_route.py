"""Websocket for the finger on a participant's page: positions in, the state of the stream out."""

from __future__ import annotations

import asyncio
import logging
import time
from contextlib import suppress
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from tactogram.errors import TactogramError
from tactogram_study.participants.bodies import FingerMessage, FingerStatus, PageToken, SlotName
from tactogram_study.participants.refusals import PROGRAM_ERROR, PROGRAM_STATUS, status_of
from tactogram_study.participants.sessions import OpenSession, SessionRegistry
from tactogram_study.participants.stimulus_routes import (
    anonymous_failure,
    current_page,
    log_slot_played,
    streams_only,
)
from tactogram_study.workflows.streams import FingerStream

NOT_UNDERSTOOD, REFUSED = 1003, 1008
"""Codes that close a websocket (RFC 6455, 7.4.1)."""

log = logging.getLogger("tactogram_studio")


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
        streams_only(session)
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
