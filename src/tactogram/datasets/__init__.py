"""Where data is and what it holds: recordings, the store, splits that cannot leak, the simulator."""

from tactogram.datasets.recording import Recording as Recording
from tactogram.datasets.recording import RecordingInfo as RecordingInfo
from tactogram.datasets.store import Store as Store
from tactogram.datasets.store import open_store as open_store
from tactogram.datasets.writing import add_recordings as add_recordings
from tactogram.datasets.writing import create_store as create_store
