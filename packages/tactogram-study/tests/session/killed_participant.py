"""Takes a study as a simulated participant and says every page that is stored, until it is killed."""

import sys
from pathlib import Path

from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import SimulatedParticipant

folder, code = Path(sys.argv[1]), sys.argv[2]
store = SessionStore(folder)
participant = store.participant(code)
simulated = SimulatedParticipant(SimulatedEffect(), (0, participant.number))
page = store.page(code)
while page is not None:
    following = store.submit(code, page.token, simulated.answer(page)).page
    sys.stdout.write(page.token + "\n")
    sys.stdout.flush()
    page = following
