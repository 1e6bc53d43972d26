from .phase import (
    recover as recover,
    spectral_convergence as spectral_convergence,
)
from .photo_pairs import (
    Protocol as Protocol,
)
from .registered_pairs import (
    FrictionBatch as FrictionBatch,
)
from .spectrogram import (
    Spectrogram as Spectrogram,
)
from .spectrogram_picture import (
    reconstructed as reconstructed,
)
from .stft import (
    STFT as STFT,
)
