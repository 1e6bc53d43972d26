"""What a tactile signal is, and what can be done with one: numpy and scipy only. Files are in `tactogram.signal.io`."""

from tactogram.signal.filters import StreamBandpass as StreamBandpass
from tactogram.signal.filters import bandpass as bandpass
from tactogram.signal.filters import dft321 as dft321
from tactogram.signal.filters import remove_gravity as remove_gravity
from tactogram.signal.filters import resample as resample
from tactogram.signal.kinematics import differentiate as differentiate
from tactogram.signal.kinematics import integrate as integrate
from tactogram.signal.perception import detection_threshold as detection_threshold
from tactogram.signal.perception import sensation_level_db as sensation_level_db
from tactogram.signal.perception import weighted as weighted
from tactogram.signal.signal import UNITS as UNITS
from tactogram.signal.signal import Image as Image
from tactogram.signal.signal import Signal as Signal
from tactogram.signal.timing import Timing as Timing
from tactogram.signal.timing import estimate_timing as estimate_timing
from tactogram.signal.timing import to_uniform as to_uniform
