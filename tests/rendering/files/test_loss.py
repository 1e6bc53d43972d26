"""What a file keeps of a signal, in words."""

import numpy as np
import pytest

from tactogram.rendering.files import ConversionLoss, loss_sentence, write_haptic
from tactogram.signal import Signal

TIME = np.arange(4000) / 2000
SWELL = Signal((0.5 + 0.5 * np.sin(2 * np.pi * TIME)) * np.sin(2 * np.pi * 150 * TIME), 2000, "1")


def told(signal, name, folder):
    written = write_haptic(folder / name, signal, format=name)
    return loss_sentence(ConversionLoss(**written["loss"]), written["holds"])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("hjif", "keeps the waveform"),
        ("haptic", "keeps the strength over time, the level and the frequency; loses the waveform"),
        ("android", "keeps the strength over time, the level and the frequency; loses the waveform"),
    ],
)
def test_each_kind_of_format_keeps_what_it_holds(name, text, tmp_path):
    assert told(SWELL, name, tmp_path) == text


def test_a_pattern_recommends_a_format_that_keeps_more(tmp_path):
    assert told(SWELL, "vibration", tmp_path).endswith(
        "A format with an envelope, such as .haptic or android, keeps more"
    )


def test_a_frequency_that_is_off_is_told(tmp_path):
    low = SWELL.with_samples((0.5 + 0.5 * np.sin(2 * np.pi * TIME)) * np.sin(2 * np.pi * 40 * TIME))
    assert "loses the waveform and the frequency (2.1 octaves off)" in told(low, "android", tmp_path)


@pytest.mark.parametrize(
    ("loss", "kept", "lost"),
    [
        (
            (0.7, 0.2, 5.0, 0.1, 0.0, -3.0),
            "roughly the strength over time and the frequency",
            "the waveform and the level (+5 dB)",
        ),
        ((None, 0.1, 0.0, None, None, None), "the strength over time and the level", "the waveform"),
        (
            (None, 0.9, -9.0, 2.0, None, None),
            "little",
            "the waveform, the changes of strength, the level (-9 dB) and the frequency (2.0 octaves off)",
        ),
    ],
)
def test_what_is_kept_stands_before_what_is_lost(loss, kept, lost):
    assert loss_sentence(ConversionLoss(*loss), "envelope") == f"keeps {kept}; loses {lost}"


def test_an_error_of_the_waveform_is_told():
    assert loss_sentence(ConversionLoss(1.0, 0.0, 0.0, 0.0, 1.0, 41.2), "waveform") == (
        "keeps the waveform with an error of -41 dB"
    )
