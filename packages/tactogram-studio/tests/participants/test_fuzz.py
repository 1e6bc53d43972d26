"""Requests that schemathesis makes up from the participants' own description: no error of the server's, whatever comes.

A small number in each run, the same ones. More with ``TACTOGRAM_FUZZ=200`` (examples for each operation and mode).
"""

import os

import hypothesis
import pytest
import schemathesis
from hypothesis import HealthCheck, strategies
from schemathesis import GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from tactogram_study.participants.routes import make_participant_app
from tactogram_study.participants.sessions import SessionRegistry

EXAMPLES = int(os.environ.get("TACTOGRAM_FUZZ", "6"))
CHECKS = (not_a_server_error, content_type_conformance, response_schema_conformance, status_code_conformance)
OPERATIONS = (
    "GET /join/{key}",
    "GET /join/{key}/study",
    "POST /join/{key}",
    "GET /take/{ticket}",
    "GET /take/{ticket}/page",
    "POST /take/{ticket}/answers",
    "POST /take/{ticket}/language",
    "GET /take/{ticket}/sound",
    "GET /take/{ticket}/image",
    "POST /take/{ticket}/play",
    "POST /take/{ticket}/stop",
)


@pytest.fixture(scope="module")
def fuzzed(tmp_path_factory, write_study_once, person, serving):
    """Give the description of the routes, a server, and somebody at their first trial."""
    folder = tmp_path_factory.mktemp("fuzzed")
    sessions = SessionRegistry(folder, device="null")
    session = sessions.begin(write_study_once(folder), folder / "session")
    schema = schemathesis.openapi.from_dict(make_participant_app(sessions).openapi())
    with serving(sessions) as client:
        one = person(client, session.join_path)
        one.go_to("abx")
        yield schema, session, client, one
    sessions.close()


def test_the_description_names_every_route(fuzzed):
    schema = fuzzed[0]
    assert {found.ok().label for found in schema.get_all_operations()} == set(OPERATIONS)


ASKED = [(label, GenerationMode.POSITIVE) for label in OPERATIONS]
# A route that takes nothing but a path has nothing that could be of a wrong form.
ASKED += [
    (label, GenerationMode.NEGATIVE)
    for label in OPERATIONS
    if "POST" in label or label.endswith(("sound", "image"))
]


@pytest.mark.parametrize(("label", "mode"), ASKED, ids=lambda value: getattr(value, "value", value))
def test_no_request_is_an_error_of_the_server(fuzzed, label, mode):
    schema, session, client, one = fuzzed
    [operation] = [found.ok() for found in schema.get_all_operations() if found.ok().label == label]
    known = {"key": session.keys.join, "ticket": one.ticket}

    @hypothesis.settings(
        max_examples=EXAMPLES,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=[hypothesis.Phase.generate],
    )
    @hypothesis.given(case=operation.as_strategy(generation_mode=mode), stranger=strategies.integers(0, 4))
    def ask(case, stranger):
        # Strangers end at the door: most have a ticket, and the token of their page.
        if stranger:
            case.path_parameters = {name: known[name] for name in known if name in label}
        if stranger > 1 and mode is GenerationMode.POSITIVE:
            token = session.store.page(one.code).token
            for place in (case.body, case.query):
                if isinstance(place, dict) and "token" in place:
                    place["token"] = token
        response = case.call(base_url=str(client.base_url).rstrip("/"), timeout=60)
        # What the guard refuses never came to a route, and is not in the routes' description.
        by_guard = response.status_code in (405, 414, 431) or b"An address holds no" in response.content
        case.validate_response(response, checks=CHECKS[:1] if by_guard else CHECKS)

    ask()
    assert one.page()["token"] is not None
