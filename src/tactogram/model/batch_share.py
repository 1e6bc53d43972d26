"""Share of a batch: the rows that one process draws where several train together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class BatchShare:
    """Share ``number``, from 0 on, of ``of`` equal shares of every batch; by default all of it."""

    number: int = 0
    of: int = 1

    @classmethod
    def of_process(cls, fabric: Any) -> Self:
        """Return the share of this process among those of a ``lightning_fabric.Fabric``."""
        return cls(fabric.global_rank, fabric.world_size)

    @property
    def purpose(self) -> tuple[int, ...]:
        """Further purpose of a `child_seed`, so that no two shares draw the same numbers; none of a whole batch."""
        return (self.number,) if self.of > 1 else ()

    def size(self, batch_size: int) -> int:
        """Return the rows of the share of a batch.

        Raises
        ------
        ParameterError
            If the batch cannot be divided into equal shares.
        """
        if batch_size % self.of:
            raise ParameterError(
                f"the batch size must be a multiple of the {self.of} processes that share a batch, got {batch_size}"
            )
        return batch_size // self.of

    def places(self, places: ArrayLike, batch_size: int) -> NDArray[np.int64]:
        """Return those of ``places``, one per row of one or more whole batches, that belong to the share.

        Both have shape (row,).
        """
        size = self.size(batch_size)
        rows = np.asarray(places, np.int64).reshape(-1, batch_size)[:, self.number * size :][:, :size]
        return np.ascontiguousarray(rows).ravel()


WHOLE_BATCH = BatchShare()
"""Share of the only process of a training."""
