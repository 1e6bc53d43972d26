"""Data sets: recordings, the store, splits that cannot leak, the simulator."""

from tactogram.datasets.examples import Examples as Examples
from tactogram.datasets.examples import part_examples as part_examples
from tactogram.datasets.examples import require_photographs as require_photographs
from tactogram.datasets.examples import signal_kind as signal_kind
from tactogram.datasets.labels import Label as Label
from tactogram.datasets.labels import label_of as label_of
from tactogram.datasets.ratings.ratings import EVOKED as EVOKED
from tactogram.datasets.ratings.ratings import SEVEN_POINT as SEVEN_POINT
from tactogram.datasets.ratings.ratings import Ratings as Ratings
from tactogram.datasets.ratings.ratings import Scale as Scale
from tactogram.datasets.ratings.ratings import item_of as item_of
from tactogram.datasets.ratings.ratings import join_ratings as join_ratings
from tactogram.datasets.recording import Recording as Recording
from tactogram.datasets.recording import RecordingInfo as RecordingInfo
from tactogram.datasets.splits.part_photographs import PhotographRegions as PhotographRegions
from tactogram.datasets.splits.part_photographs import (
    materials_without_photographs as materials_without_photographs,
)
from tactogram.datasets.splits.part_photographs import (
    materials_without_recordings as materials_without_recordings,
)
from tactogram.datasets.splits.photograph_splitting import split_photographs as split_photographs
from tactogram.datasets.splits.photograph_splitting import whole_photographs as whole_photographs
from tactogram.datasets.splits.split import Region as Region
from tactogram.datasets.splits.split import Segment as Segment
from tactogram.datasets.splits.split import Split as Split
from tactogram.datasets.splits.splitting import contiguous_blocks as contiguous_blocks
from tactogram.datasets.splits.splitting import kfold as kfold
from tactogram.datasets.splits.splitting import split_fractions as split_fractions
from tactogram.datasets.splits.splitting import split_last as split_last
from tactogram.datasets.store.store import Store as Store
from tactogram.datasets.store.store import open_store as open_store
from tactogram.datasets.store.writing import add_ratings as add_ratings
from tactogram.datasets.store.writing import add_recordings as add_recordings
from tactogram.datasets.store.writing import create_store as create_store
