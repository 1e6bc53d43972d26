"""Windows of fabrics in the layout that FrictGAN's authors' code opens."""

import numpy as np
from PIL import Image as Pillow
from scipy.signal.windows import hamming


def amplitudes(friction):
    """Return what `librosa.stft(friction, n_fft=512, hop_length=128, window="hamming", pad_mode="reflect")` has."""
    padded = np.pad(friction, 256, mode="reflect")
    return np.abs([np.fft.rfft(hamming(512, sym=False) * padded[128 * k :][:512]) for k in range(11)]).T


def friction_of(seed):
    rng = np.random.default_rng(seed)
    return 0.4 + 0.02 * np.sin(np.arange(1280) / 7) + 0.005 * rng.standard_normal(1280)


def write_window(folder, number, friction):
    """Write a photograph's window, with as many rows as a test needs, and the amplitudes of its friction."""
    for name in ("image", "output_data"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "output_data" / f"{number}.txt", amplitudes(friction))
    pixels = np.random.default_rng(number).integers(0, 255, (40, 1024, 3), dtype=np.uint8)
    Pillow.fromarray(pixels).save(folder / "image" / f"{number}.jpg")
