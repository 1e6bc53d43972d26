"""Where data is and what it holds: recordings, the store, splits that cannot leak, the simulator."""

from tactogram.datasets.recording import Recording as Recording
from tactogram.datasets.recording import RecordingInfo as RecordingInfo
