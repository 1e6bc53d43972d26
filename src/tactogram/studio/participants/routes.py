"""The routes that participants' pages speak to. A ticket reaches its own participant, and nothing else.

Nothing that is sent says which stimulus is which: no names, no files, no conditions; an error in making one is told to
the experimenter only. Answers are on the disk before the next page is known (`tactogram.study.session.store`).
"""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, FastAPI, Query, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, HTMLResponse
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.studio.participants.allowance import RateLimiter
from tactogram.studio.participants.bodies import (
    AnswersRequest,
    AnswersResponse,
    EmptyRequest,
    ErrorResponse,
    JoinRequest,
    JoinResponse,
    LanguageRequest,
    OfferResponse,
    PageResponse,
    PageToken,
    PlayRequest,
    PlayResponse,
    SlotName,
    StopResponse,
    plain,
)
from tactogram.studio.participants.playing import DisplayInUseError
from tactogram.studio.participants.prepared import wav_bytes
from tactogram.studio.participants.sessions import (
    NO_TICKET,
    OpenSession,
    SessionRegistry,
    UnknownSessionError,
)
from tactogram.study.session.participants import PageNotOpenError, UnknownParticipantError
from tactogram.study.session.progress import ParticipantState
from tactogram.study.trials import Page, Participant
from tactogram.workflows.study.stimuli import SlotPlayback

STATIC = Path(__file__).parent / "static"
KINDS = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,60}\.(js|css|svg)")
NO_LINK = (
    "<!doctype html><html lang='en'><meta charset='utf-8'>"
    "<meta name='viewport' content='width=device-width, initial-scale=1'><title>tactogram</title>"
    "<p lang='ja'>このリンクは使えません。実験者にお知らせください。</p>"
    "<p>This link does not work. Please tell the experimenter.</p></html>"
)
BEHIND = "this belongs to another page than the present one; reload it"
CANNOT_PLAY = "this stimulus cannot be played; please call the experimenter"
NOT_STORED = "this could not be stored; please call the experimenter"
PROGRAM = "this did not work because of an error in the program; please call the experimenter"

Handler = Callable[[Request], Coroutine[Any, Any, Response]]
log = logging.getLogger("tactogram.studio")


class OutdatedPageError(TactogramError):
    """The answers belong to another page than the current one."""


class StimulusPlaybackError(TactogramError):
    """A stimulus could not be made or played."""


class RateLimitError(TactogramError):
    """Something was tried too often."""

    def __init__(self, wait_s: float) -> None:
        super().__init__(f"this was tried too often; wait {wait_s:.0f} s and try again")
        self.wait_s = wait_s


class SentenceRoute(APIRoute):
    """A route whose errors are one sentence in JSON, and which takes no body but JSON."""

    def get_route_handler(self) -> Handler:
        """Return the handler with its errors told."""
        handler = super().get_route_handler()

        async def told(request: Request) -> Response:
            kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
            if request.method == "POST" and kind != "application/json":
                return _refused(415, "a body must be JSON; send it with Content-Type: application/json")
            try:
                return await handler(request)
            except RequestValidationError as error:
                return _refused(400, _sentence(error))
            except HTTPException as error:
                return _refused(
                    error.status_code, "a body must be JSON of ordinary size and depth; send it again"
                )
            except RateLimitError as error:
                return _refused(429, str(error), {"retry-after": str(max(1, round(error.wait_s)))})
            except DataError as error:
                # Where the file lies, and what is wrong with it, is for the experimenter.
                log.warning("%s", error)
                return _refused(503, NOT_STORED)
            except TactogramError as error:
                return _refused(_status(error), str(error))
            except Exception:
                log.exception("%s failed", self.path)
                return _refused(500, PROGRAM)

        return told


def make_participant_app(sessions: SessionRegistry) -> FastAPI:
    """Return the participants' pages alone, as an application to be wrapped in a `Guard`."""
    app = FastAPI(title="tactogram: pages for participants", docs_url=None, redoc_url=None)
    app.include_router(participant_router(sessions))
    return app


def participant_router(sessions: SessionRegistry) -> APIRouter:
    """Return the routes under ``/join``, ``/take`` and ``/participants``."""
    refusals: dict[int | str, dict[str, Any]] = {
        status: {"model": ErrorResponse} for status in ("4XX", 400, 404, 409, 413, 415, 423, 429, 503)
    }
    router = APIRouter(route_class=SentenceRoute, responses=refusals)
    _add_files(router)
    _add_joining(router, sessions)
    _add_pages(router, sessions)
    _add_stimuli(router, sessions)
    return router


def _add_files(router: APIRouter) -> None:
    @router.get("/participants/static/{name}", include_in_schema=False)
    def static(name: str) -> Response:
        """Return a file of the pages."""
        path = STATIC / name
        if not _NAME.fullmatch(name) or not path.is_file():
            raise UnknownSessionError(f"there is no file {name[:60]!r}")
        return FileResponse(path, media_type=KINDS[path.suffix], headers={"cache-control": "no-cache"})


def _add_joining(router: APIRouter, sessions: SessionRegistry) -> None:
    # A code is one of 7 million; who guesses is slowed down, one address first, all together later.
    guesses = {"address": RateLimiter(8, 10.0), "session": RateLimiter(60, 1.0)}
    newcomers = RateLimiter(100, 1.0)

    @router.get("/join/{key}", response_class=HTMLResponse)
    def join_page(key: str) -> Response:
        """Return the page to begin or go on from."""
        try:
            sessions.joined_at(key).stimuli.begin()
        except UnknownSessionError:
            return HTMLResponse(NO_LINK, 404)
        return _page_file("join.html")

    @router.get("/join/{key}/study")
    def offered(key: str) -> OfferResponse:
        """Return the study's title in its languages."""
        study = sessions.joined_at(key).study
        titles: dict[str, str] = {language: study.title.in_language(language) for language in study.languages}
        return OfferResponse(title=titles, languages=list(study.languages), open=True)

    @router.post("/join/{key}")
    def join(key: str, body: JoinRequest, request: Request) -> JoinResponse:
        """Enrol somebody, or let them go on by their code."""
        session = sessions.joined_at(key)
        if body.code.strip():
            address = request.client.host if request.client else ""
            participant = _by_code(session, body, guesses, address)
        else:
            _spend(newcomers, session.folder)
            participant = session.join(body.attempt, body.language, body.device)
        session.stimuli.begin()
        return JoinResponse(ticket=session.keys.ticket(participant.code), code=participant.code)


def _add_pages(router: APIRouter, sessions: SessionRegistry) -> None:
    @router.get("/take/{ticket}", response_class=HTMLResponse)
    def take_page(ticket: str) -> Response:
        """Return the page that shows all others; the same for everybody."""
        try:
            sessions.of_ticket(ticket)[0].stimuli.begin()
        except UnknownSessionError:
            return HTMLResponse(NO_LINK, 404)
        return _page_file("take.html")

    @router.get("/take/{ticket}/page")
    def page(ticket: str) -> PageResponse:
        """Return what is shown now."""
        session, standing = sessions.of_ticket(ticket)
        # Who loads the page again hears nothing of before.
        sessions.display.stop(ticket)
        return PageResponse(**_shown(session, standing))

    @router.post("/take/{ticket}/answers")
    async def answer(ticket: str, body: AnswersRequest) -> AnswersResponse:
        """Store the answers to a page, once, and return what is next."""
        session, code = await _holder(sessions, ticket)
        return await session.writes.done(partial(_answered, session, code, body))

    @router.post("/take/{ticket}/language")
    def language(ticket: str, body: LanguageRequest) -> PageResponse:
        """Go on in another language."""
        session, standing = sessions.of_ticket(ticket)
        session.store.set_language(standing.participant.code, body.language)
        return PageResponse(**_shown(*sessions.of_ticket(ticket)))


def _add_stimuli(router: APIRouter, sessions: SessionRegistry) -> None:
    files: dict[int | str, dict[str, Any]] = {
        200: {"content": {"audio/wav": {}}, "description": "32-bit floats"}
    }
    pictures: dict[int | str, dict[str, Any]] = {
        200: {"content": {"image/png": {}}, "description": "a picture"}
    }

    @router.get("/take/{ticket}/sound", response_class=Response, responses=files)
    async def sound(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return what a slot of the present page plays, and log it as played."""
        made = await anyio.to_thread.run_sync(sound_of, ticket, token, slot)
        session, code, wav, played = made
        await session.writes.done(partial(_log_played, session, code, token, slot, played))
        # Neither hash nor level goes with it: they would say in words what only the skin is to tell.
        return Response(wav, media_type="audio/wav")

    def sound_of(ticket: str, token: str, slot: str) -> tuple[OpenSession, str, bytes, SlotPlayback]:
        session, code, present = _at(sessions, ticket, token, slot)
        if session.study.played_by != "browser":
            raise ParameterError("this study plays at the server; send play")
        with _blind(session):
            drive, played = session.stimuli.drive(present, slot)
            return session, code, wav_bytes(drive), played

    @router.get("/take/{ticket}/image", response_class=Response, responses=pictures)
    def image(ticket: str, token: Annotated[PageToken, Query()], slot: SlotName = "") -> Response:
        """Return the picture of a slot of the present page."""
        session, _, present = _at(sessions, ticket, token, slot)
        if not any(
            shown.slot == slot and shown.stimulus and shown.stimulus.is_seen for shown in present.presented
        ):
            raise ParameterError(f"slot {slot!r} shows no picture")
        with _blind(session):
            return Response(session.stimuli.picture(present, slot), media_type="image/png")

    @router.post("/take/{ticket}/play")
    def play(ticket: str, body: PlayRequest) -> PlayResponse:
        """Play a slot of the present page on the server's display; answers when it has ended."""
        session, code, present = _at(sessions, ticket, body.token, body.slot)
        if session.study.played_by != "server":
            raise ParameterError("this study plays in the browser; get sound")
        with _blind(session):
            drive, played = session.stimuli.drive(present, body.slot)
            display = session.stimuli.display(present.slot(body.slot))
        _log_played(session, code, body.token, body.slot, played)
        with _blind(session):
            facts = sessions.display.play(ticket, drive, display)
        return PlayResponse(state=facts["state"], simulated_device=facts["simulated_device"])

    @router.post("/take/{ticket}/stop")
    def stop(ticket: str, body: EmptyRequest) -> StopResponse:
        """Fade out what is playing to this participant."""
        sessions.of_ticket(ticket)
        return StopResponse(stopped=sessions.display.stop(ticket))


@contextmanager
def _blind(session: OpenSession) -> Iterator[None]:
    """Tell a participant that a stimulus failed, and not which; the experimenter is told in ``troubles``."""
    try:
        yield
    except DisplayInUseError:
        raise
    except Exception as error:
        if isinstance(error, TactogramError):
            log.warning("%s: %s", session.name, error)
        else:
            log.exception("%s: a stimulus failed", session.name)
        troubles = session.stimuli.troubles
        if str(error) not in troubles.values():
            troubles[""] = " ".join(str(error).split())[:300] or type(error).__name__
        raise StimulusPlaybackError(CANNOT_PLAY) from error


async def _holder(sessions: SessionRegistry, ticket: str) -> tuple[OpenSession, str]:
    """Return the session that a ticket belongs to and whose it is, from memory where it was seen before."""
    held = sessions.holder(ticket, look=False) or await anyio.to_thread.run_sync(sessions.holder, ticket)
    if held is None:
        raise UnknownSessionError(NO_TICKET)
    return held


def _answered(session: OpenSession, code: str, body: AnswersRequest) -> AnswersResponse:
    """Store the answers to a page, and return what is next."""
    try:
        done = session.store.submit(code, body.token, body.answers, rt_ms=body.rt_ms, device=body.device)
    except UnknownParticipantError:  # withdrawn
        raise UnknownSessionError(NO_TICKET) from None
    except PageNotOpenError as error:
        raise OutdatedPageError(
            "these answers belong to another page than the present one; reload it"
        ) from error
    return AnswersResponse(stored=done.stored, **_shown(session, done.standing))


def _at(sessions: SessionRegistry, ticket: str, token: str, slot: str) -> tuple[OpenSession, str, Page]:
    """Return whose ticket it is and their present page, if it is the one of the token and has the slot."""
    session, standing = sessions.of_ticket(ticket)
    page = standing.page
    if page is None or page.token != token:
        raise OutdatedPageError(BEHIND)
    page.slot(slot)
    return session, standing.participant.code, page


def _shown(session: OpenSession, standing: ParticipantState) -> dict[str, Any]:
    study, participant, page = session.study, standing.participant, standing.page
    if page is not None:
        session.stimuli.ahead(page)
    return {
        "page": None if page is None else plain(page.shown(participant.language)),
        "title": study.title.in_language(participant.language),
        "languages": list(study.languages),
        "language": participant.language,
        "code": participant.code,
        "played_by": study.played_by,
        "progress": {"trial": 0 if page is None else page.trial, "of": 0 if page is None else page.total},
        "state": standing.state,
    }


def _by_code(
    session: OpenSession, body: JoinRequest, guesses: dict[str, RateLimiter], address: str
) -> Participant:
    keys = {"address": (session.folder, address), "session": session.folder}
    if wait_s := max(guesses[kind].wait_s(key) for kind, key in keys.items()):
        raise RateLimitError(wait_s)
    try:
        participant = session.store.participant(body.code.strip())
    except ParameterError as error:
        for kind, key in keys.items():
            guesses[kind].spend(key)
        raise UnknownSessionError(
            "no participant has this code; look at it again, or ask the experimenter"
        ) from error
    if session.store.state(participant.code) == "going":
        session.store.note_device(participant.code, body.device)
        if body.language in session.study.languages:
            session.store.set_language(participant.code, body.language)
    return participant


def _spend(allowance: RateLimiter, key: object) -> None:
    if wait_s := allowance.wait_s(key):
        raise RateLimitError(wait_s)
    allowance.spend(key)


def _log_played(session: OpenSession, code: str, token: str, slot: str, played: SlotPlayback) -> None:
    try:
        session.store.log_played(
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
        raise OutdatedPageError(BEHIND) from error


def _page_file(name: str) -> Response:
    return HTMLResponse((STATIC / name).read_text(encoding="utf-8"))


def _status(error: TactogramError) -> int:
    kinds = (
        (UnknownSessionError, 404),
        (OutdatedPageError, 409),
        (DisplayInUseError, 423),
        (ParameterError, 400),
    )
    return next((status for kind, status in kinds if isinstance(error, kind)), 503)


def _refused(status: int, sentence: str, headers: dict[str, str] | None = None) -> Response:
    # json's own escapes: a text may hold halves of characters, which no bytes stand for.
    body = json.dumps({"error": " ".join(sentence.split())})
    return Response(body, status, headers=headers, media_type="application/json")


def _sentence(error: RequestValidationError) -> str:
    first = error.errors()[0]
    place = ".".join(str(part)[:40] for part in first["loc"] if part != "body")
    return f"{place or 'body'}: {first['msg']}"
