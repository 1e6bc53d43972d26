"""Routes of participants' pages. A ticket reaches its own participant, and nothing else.

No response reveals which stimulus is which: no names, files or conditions; errors in making one are for the
experimenter. Answers are on the disk before the next page is known (`tactogram_study.session.store`).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Literal

import anyio
import anyio.to_thread
from fastapi import APIRouter, FastAPI, Response
from fastapi.responses import FileResponse, HTMLResponse

from tactogram.errors import ParameterError
from tactogram.text_files import finite_json
from tactogram_study.participants.bodies import (
    AnswersRequest,
    AnswersResponse,
    ErrorResponse,
    JoinRequest,
    JoinResponse,
    LanguageRequest,
    OfferResponse,
    PageResponse,
)
from tactogram_study.participants.refusals import (
    OutdatedPageError,
    RateLimiter,
    SentenceRoute,
)
from tactogram_study.participants.sessions import (
    NO_TICKET,
    OpenSession,
    SessionRegistry,
    UnknownSessionError,
)
from tactogram_study.participants.stimulus_routes import add_finger_route, add_stimulus_routes
from tactogram_study.session.participants import PageNotOpenError, UnknownParticipantError
from tactogram_study.session.progress import ParticipantState
from tactogram_study.trials import Participant
from tactogram_study.wording import complete_texts, language_texts, paragraphs

STATIC = Path(__file__).parent / "static"
MEDIA_TYPES = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,60}\.(js|css|svg)")
WRONG_CODE_S = 0.2
"""A wrong code holds up the session's next one this long: 18,000 guesses an hour, of 1.4e9 codes."""
NO_CACHE = {"cache-control": "no-cache"}
BROKEN_LINK = (
    "<!doctype html><html lang='en'><meta charset='utf-8'>"
    "<meta name='viewport' content='width=device-width, initial-scale=1'><title>tactogram</title>{said}</html>"
)


def make_participant_app(sessions: SessionRegistry) -> FastAPI:
    """Return the participants' pages alone, as an application to be wrapped in a `RequestGuard`."""
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
    add_stimulus_routes(router, sessions)
    add_finger_route(router, sessions)
    return router


def _add_files(router: APIRouter) -> None:
    @router.get("/participants/static/{name}", include_in_schema=False)
    def static(name: str) -> Response:
        """Return a file of the pages."""
        path = STATIC / name
        if not _NAME.fullmatch(name) or not path.is_file():
            raise UnknownSessionError(f"there is no file {name[:60]!r}")
        return FileResponse(path, media_type=MEDIA_TYPES[path.suffix], headers=NO_CACHE)

    @router.get("/participants/languages.js", include_in_schema=False)
    def languages() -> Response:
        """Return the texts of the pages in every language, as a module."""
        texts = {language: complete_texts(language) for language in language_texts()}
        script = f"export default {json.dumps(texts, ensure_ascii=False)};\n"
        return Response(script, media_type=MEDIA_TYPES[".js"], headers=NO_CACHE)


def _add_joining(router: APIRouter, sessions: SessionRegistry) -> None:
    newcomers = RateLimiter(100, 1.0)

    @router.get("/join/{key}", response_class=HTMLResponse)
    def join_page(key: str) -> Response:
        """Return the page to begin or continue from."""
        try:
            session = sessions.by_join_key(key)
        except UnknownSessionError:
            return _broken_link()
        session.stimuli.start()
        return _page_file("join", session)

    @router.get("/join/{key}/study")
    def offered(key: str) -> OfferResponse:
        """Return the study's title in its languages."""
        study = sessions.by_join_key(key).study
        titles: dict[str, str] = {language: study.title.in_language(language) for language in study.languages}
        return OfferResponse(title=titles, languages=list(study.languages), open=True)

    @router.post("/join/{key}")
    async def join(key: str, body: JoinRequest) -> JoinResponse:
        """Enrol a new participant, or let one continue with their code.

        Codes are looked up one after the other: however many are guessed, and from whichever address, the right one
        waits its turn and is never refused.
        """
        session = sessions.by_join_key(key)
        if body.code.strip():
            async with session.guessing:
                try:
                    participant = await anyio.to_thread.run_sync(_by_code, session, body)
                except UnknownSessionError:
                    await anyio.sleep(WRONG_CODE_S)
                    raise
        else:
            newcomers.spend(session.folder)
            participant = await anyio.to_thread.run_sync(
                session.join, body.attempt, body.language, body.device
            )
        session.stimuli.start()
        return JoinResponse(ticket=session.keys.ticket(participant.code), code=participant.code)


def _add_pages(router: APIRouter, sessions: SessionRegistry) -> None:
    @router.get("/take/{ticket}", response_class=HTMLResponse)
    def take_page(ticket: str) -> Response:
        """Return the page that shows all pages of a study; the same for everybody."""
        try:
            session, _ = sessions.state_of(ticket)
        except UnknownSessionError:
            return _broken_link()
        session.stimuli.start()
        return _page_file("take", session)

    @router.get("/take/{ticket}/page")
    def page(ticket: str) -> PageResponse:
        """Return the current page."""
        session, state = sessions.state_of(ticket)
        # A reload stops what the page played before.
        sessions.display.stop(ticket)
        return PageResponse(**_page_fields(session, state))

    @router.post("/take/{ticket}/answers")
    async def answer(ticket: str, body: AnswersRequest) -> AnswersResponse:
        """Store the answers to a page, once, and return the next page."""
        entry = sessions.by_ticket(ticket, cached=True)
        entry = entry or await anyio.to_thread.run_sync(sessions.by_ticket, ticket)
        if entry is None:
            raise UnknownSessionError(NO_TICKET)
        session, code = entry
        return await anyio.to_thread.run_sync(_store_answers, session, code, body, limiter=session.writing)

    @router.post("/take/{ticket}/language")
    def language(ticket: str, body: LanguageRequest) -> PageResponse:
        """Switch the language and return the current page."""
        session, state = sessions.state_of(ticket)
        session.store.set_language(state.participant.code, body.language)
        return PageResponse(**_page_fields(*sessions.state_of(ticket)))


def _store_answers(session: OpenSession, code: str, body: AnswersRequest) -> AnswersResponse:
    try:
        done = session.store.submit(code, body.token, body.answers, rt_ms=body.rt_ms, device=body.device)
    except UnknownParticipantError:  # withdrawn
        raise UnknownSessionError(NO_TICKET) from None
    except PageNotOpenError as error:
        raise OutdatedPageError from error
    return AnswersResponse(stored=done.stored, **_page_fields(session, done.state))


def _page_fields(session: OpenSession, state: ParticipantState) -> dict[str, Any]:
    study, participant, page = session.study, state.participant, state.page
    if page is not None:
        session.stimuli.prepare(page)
    return {
        "page": None if page is None else finite_json(page.shown(participant.language)),
        "title": study.title.in_language(participant.language),
        "languages": list(study.languages),
        "language": participant.language,
        "code": participant.code,
        "played_by": study.played_by,
        "progress": {"trial": 0 if page is None else page.trial, "of": 0 if page is None else page.total},
        "state": state.state,
    }


def _by_code(session: OpenSession, body: JoinRequest) -> Participant:
    try:
        participant = session.store.participant(body.code.strip())
    except ParameterError as error:
        raise UnknownSessionError(
            "no participant has this code; check it, or ask the experimenter"
        ) from error
    if session.store.state(participant.code) == "going":
        session.store.log_device(participant.code, body.device)
        if body.language in session.study.languages:
            session.store.set_language(participant.code, body.language)
    return participant


def _page_file(script: Literal["join", "take"], session: OpenSession) -> Response:
    page = (STATIC / "page.html").read_text(encoding="utf-8").replace("{script}", script)
    return HTMLResponse(page.replace("{reload}", paragraphs("reload", session.study.languages)))


def _broken_link() -> Response:
    return HTMLResponse(BROKEN_LINK.format(said=paragraphs("no_ticket")), 404)
