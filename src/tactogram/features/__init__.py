"""Between a signal and what a network sees: torch, differentiable, invertible."""

from tactogram.features.levels import AmplitudeScale as AmplitudeScale
from tactogram.features.phase import fast_griffin_lim as fast_griffin_lim
from tactogram.features.phase import griffin_lim as griffin_lim
from tactogram.features.phase import recover as recover
from tactogram.features.phase import spectral_convergence as spectral_convergence
from tactogram.features.phase_gradient import gradient_phase as gradient_phase
from tactogram.features.spectrogram import Spectrogram as Spectrogram
from tactogram.features.spectrum import Spectrum as Spectrum
from tactogram.features.stft import STFT as STFT
