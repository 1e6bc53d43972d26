"""Transforms between signals or photographs and a network's input: torch, differentiable, invertible."""

from tactogram.features.phase import recover as recover
from tactogram.features.phase import spectral_convergence as spectral_convergence
from tactogram.features.phase_gradient import gradient_phase as gradient_phase
from tactogram.features.spectrogram import Spectrogram as Spectrogram
from tactogram.features.stft import STFT as STFT
