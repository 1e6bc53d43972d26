"""What a tactile signal is, and what can be done with one: numpy and scipy only."""

from tactogram.signal.signal import UNITS as UNITS
from tactogram.signal.signal import Image as Image
from tactogram.signal.signal import Signal as Signal
