"""Rate limiter: a burst of attempts per key, refilled over time."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable

MOST_KEYS = 10_000


class RateLimiter:
    """At most ``burst`` attempts at once for each key, and one more every ``refill_s``. In memory only."""

    def __init__(self, burst: int, refill_s: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.burst, self.refill_s = burst, refill_s
        self._clock = clock
        self._spent: OrderedDict[Hashable, tuple[float, float]] = OrderedDict()
        self._guard = threading.Lock()

    def wait_s(self, key: Hashable) -> float:
        """Return the seconds until the next attempt is allowed; 0 is now."""
        with self._guard:
            return max(0.0, (self._used(key) + 1 - self.burst) * self.refill_s)

    def spend(self, key: Hashable) -> None:
        """Count an attempt."""
        with self._guard:
            self._spent[key] = (self._used(key) + 1, self._clock())
            self._spent.move_to_end(key)
            if len(self._spent) > MOST_KEYS:
                self._spent.popitem(last=False)

    def _used(self, key: Hashable) -> float:
        """Return the attempts that have not been refilled yet."""
        spent, since = self._spent.get(key, (0.0, 0.0))
        return max(0.0, spent - (self._clock() - since) / self.refill_s)
