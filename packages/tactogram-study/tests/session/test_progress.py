"""Where participants stand."""

from tactogram_study.session import progress as session_standing
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import SimulatedParticipant, simulate, take


def answer(store, code, count=1):
    """Answer so many pages as a simulated participant."""
    participant = store.participant(code)
    return take(
        store, participant, SimulatedParticipant(SimulatedEffect(), (0, participant.number)), most_pages=count
    )


def test_what_is_next_is_computed_once(store, monkeypatch):
    computed, next_page = [], session_standing.next_page
    monkeypatch.setattr(session_standing, "next_page", lambda *a: computed.append(a) or next_page(*a))
    code = store.enrol().code
    for token in ("consent", "before", "trial-1.1", "trial-2.1"):
        page = store.page(code)
        assert page.token == token
        store.submit(code, token, {one.key: one.question.options[0].value for one in page.questions})
    assert len(computed) == 5


def test_progress_says_where_everybody_stands(store):
    store.enrol("P1", simulated=True)
    store.enrol("P2", simulated=True)
    answer(store, "P2", 4)
    store.submit("P1", "consent", {"consent": "declined"})
    simulate(store, 1)
    store.enrol("P4", simulated=True)
    assert [(p["status"], p["trials"], p["of"]) for p in store.progress()] == [
        ("declined", 0, 8),
        ("active", 2, 8),
        ("finished", 8, 8),
        ("not begun", 0, 8),
    ]
