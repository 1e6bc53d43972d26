"""Layouts of tables as phones, loggers, instruments, programs and scripts write them, with the right answers."""

from tests.signal.io.foreign.case import Case, check
from tests.signal.io.foreign.cells import CELLS
from tests.signal.io.foreign.clocks import CLOCKS
from tests.signal.io.foreign.given import GIVEN
from tests.signal.io.foreign.instruments import INSTRUMENTS
from tests.signal.io.foreign.interleaved import INTERLEAVED
from tests.signal.io.foreign.laboratory import LABORATORY
from tests.signal.io.foreign.loggers import LOGGERS
from tests.signal.io.foreign.phones import PHONES
from tests.signal.io.foreign.programs import PROGRAMS
from tests.signal.io.foreign.refused import REFUSED
from tests.signal.io.foreign.serial import SERIAL

CASES: tuple[Case, ...] = (
    *PHONES,
    *LOGGERS,
    *INSTRUMENTS,
    *LABORATORY,
    *PROGRAMS,
    *SERIAL,
    *CLOCKS,
    *CELLS,
    *INTERLEAVED,
    *REFUSED,
    *GIVEN,
)

__all__ = ["CASES", "Case", "check"]
