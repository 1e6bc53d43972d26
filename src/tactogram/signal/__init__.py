"""Tactile signals: types, filters, synthesis, perception; files are read and written by `tactogram.signal.io`.

Only the types are imported here: scipy's filters take longer to load than a stimulus to play.
"""

from tactogram.signal.signal import UNITS as UNITS
from tactogram.signal.signal import Image as Image
from tactogram.signal.signal import Signal as Signal
