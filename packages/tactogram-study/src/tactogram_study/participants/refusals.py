"""Refusals of participants' routes: every error is one sentence in JSON, without details for the experimenter."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable, Coroutine, Hashable
from typing import Any

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram_study.participants.server_display import DisplayInUseError
from tactogram_study.participants.sessions import UnknownSessionError


class RateLimiter:
    """At most ``burst`` attempts at once for each of few keys, and one more every ``refill_s``. In memory only."""

    def __init__(self, burst: int, refill_s: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.burst, self.refill_s = burst, refill_s
        self._clock = clock
        self._spent: dict[Hashable, tuple[float, float]] = {}

    def spend(self, key: Hashable) -> None:
        """Count an attempt, or raise `RateLimitError` if it comes too early."""
        now = self._clock()
        spent, since = self._spent.get(key, (0.0, now))
        used = max(0.0, spent - (now - since) / self.refill_s) + 1
        if used > self.burst:
            raise RateLimitError((used - self.burst) * self.refill_s)
        self._spent[key] = (used, now)


CANNOT_PLAY = "this stimulus cannot be played; please call the experimenter"
NOT_STORED = "this could not be stored; please call the experimenter"
PROGRAM_ERROR = "this failed because of an error in the program; please call the experimenter"

log = logging.getLogger("tactogram_studio")


class OutdatedPageError(TactogramError):
    """The request is about another page than the current one."""

    def __init__(self) -> None:
        super().__init__("this page is out of date; reload it")


class StimulusPlaybackError(TactogramError):
    """A stimulus could not be made or played."""


class RateLimitError(TactogramError):
    """Too many attempts."""

    def __init__(self, wait_s: float) -> None:
        super().__init__(f"too many attempts; wait {wait_s:.0f} s and try again")
        self.wait_s = wait_s


STATUS = (
    (UnknownSessionError, 404),
    (OutdatedPageError, 409),
    (DisplayInUseError, 423),
    (ParameterError, 400),
)
"""HTTP status by kind of error; 503 for all others."""
PROGRAM_STATUS = 500
"""Of errors in the program."""


def status_of(error: TactogramError) -> int:
    """Return the HTTP status of an error."""
    return next((status for kind, status in STATUS if isinstance(error, kind)), 503)


class SentenceRoute(APIRoute):
    """A route whose errors are one sentence in JSON, and which accepts JSON bodies only."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler, with errors turned into responses."""
        handler = super().get_route_handler()

        async def handle(request: Request) -> Response:
            kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
            if request.method == "POST" and kind != "application/json":
                return _refused(415, "a body must be JSON; send it with Content-Type: application/json")
            try:
                return await handler(request)
            except RequestValidationError as error:
                return _refused(400, sentence_of(error))
            except HTTPException as error:
                return _refused(
                    error.status_code, "a body must be JSON of ordinary size and depth; send it again"
                )
            except RateLimitError as error:
                return _refused(429, str(error), {"retry-after": str(max(1, round(error.wait_s)))})
            except DataError as error:
                # The file's path and what is wrong with it are for the experimenter.
                log.warning("%s", error)
                return _refused(503, NOT_STORED)
            except TactogramError as error:
                if isinstance(error, ParameterError):
                    # The pages send nothing invalid, and show a participant what to do only.
                    log.warning("%s: %s", self.path, error)
                return _refused(status_of(error), str(error))
            except Exception:
                log.exception("%s failed", self.path)
                return _refused(PROGRAM_STATUS, PROGRAM_ERROR)

        return handle


def _refused(status: int, sentence: str, headers: dict[str, str] | None = None) -> Response:
    # Escaped by json: a text may hold lone surrogates, which cannot be encoded.
    body = json.dumps({"error": " ".join(sentence.split())})
    return Response(body, status, headers=headers, media_type="application/json")


def sentence_of(error: RequestValidationError) -> str:
    """Return what is wrong with the first invalid value of a request."""
    first = error.errors()[0]
    field = ".".join(str(part)[:40] for part in first["loc"] if part != "body")
    return f"{field or 'body'}: {first['msg']}"
