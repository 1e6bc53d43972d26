"""Bodies of requests: what is refused before it is read."""

import pytest
from pydantic import ValidationError

from tactogram_study.participants.bodies import AnswersRequest, FingerMessage, JoinRequest


def test_who_joins_needs_a_language_alone():
    request = JoinRequest.model_validate({"language": "en"})
    assert (request.code, request.attempt, request.device) == ("", "", {})


@pytest.mark.parametrize(
    ("body", "of"),
    [
        (JoinRequest, {"language": "en", "code": "x" * 41}),
        (JoinRequest, {"language": "en", "attempt": "../etc"}),
        (JoinRequest, {"language": "en", "device": {str(n): n for n in range(101)}}),
        (JoinRequest, {"language": "en", "admin": True}),
        (AnswersRequest, {"token": "a", "answers": {str(n): "1" for n in range(501)}}),
        (FingerMessage, {"slot": "A", "samples": [(0, 0, 0)]}),
        (FingerMessage, {"slot": "A", "samples": [(0, 0, 0, 1)] * 501}),
    ],
)
def test_what_is_too_long_unknown_or_misshapen_is_refused(body, of):
    with pytest.raises(ValidationError):
        body.model_validate(of)


def test_a_request_is_not_changed():
    message = FingerMessage(slot="A", samples=[(0.0, 1.0, 2.0, 1.0)])
    with pytest.raises(ValidationError, match="frozen"):
        message.slot = "B"
