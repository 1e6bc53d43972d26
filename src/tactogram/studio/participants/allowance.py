"""Rate limiter: an allowance that is spent and refills with time."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable

MOST_KEPT = 10_000


class RateLimiter:
    """So many at once, and one more every so often, for each key. Nothing is written down.

    Parameters
    ----------
    most : int
        At once.
    refill_s : float
        After which one more is allowed.
    clock : callable
        Seconds that never go back.
    """

    def __init__(self, most: int, refill_s: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.most, self.refill_s = most, refill_s
        self._clock = clock
        self._spent: OrderedDict[Hashable, tuple[float, float]] = OrderedDict()
        self._guard = threading.Lock()

    def wait_s(self, key: Hashable) -> float:
        """Return in how many seconds one is allowed; 0 is now."""
        with self._guard:
            return max(0.0, (self._left(key) + 1 - self.most) * self.refill_s)

    def spend(self, key: Hashable) -> None:
        """Note one."""
        with self._guard:
            self._spent[key] = (self._left(key) + 1, self._clock())
            self._spent.move_to_end(key)
            if len(self._spent) > MOST_KEPT:
                self._spent.popitem(last=False)

    def _left(self, key: Hashable) -> float:
        """Return how many are spent and not refilled."""
        spent, since = self._spent.get(key, (0.0, 0.0))
        return max(0.0, spent - (self._clock() - since) / self.refill_s)
