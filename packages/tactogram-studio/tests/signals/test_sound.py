"""What a browser plays of a signal."""

import io

import numpy as np
import pytest
import soundfile
from hypothesis import given, strategies as st

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram_studio.signals.sound import (
    KNEE,
    NORMAL_PEAK,
    RATE,
    common_gain,
    range_response,
    soft_limited,
    sound_of,
    sound_text,
)

DATA = bytes(range(10))


def read(wav):
    return soundfile.read(io.BytesIO(wav), dtype="float32")


def tone(amplitude, *, rate=1000.0, seconds=1.0, offset=0.0, axes=1):
    t = np.arange(round(seconds * rate)) / rate
    one = offset + amplitude * np.sin(2 * np.pi * 100 * t)
    return Signal(np.tile(one, (axes, 1)), rate, "m/s^2", tuple("abcdefg"[:axes]))


def test_a_level_of_its_own_is_told():
    made = sound_of(tone(0.02, offset=9.8))

    samples, rate = read(made.wav)
    assert (rate, samples.ndim, len(samples)) == (RATE, 1, RATE)
    assert np.abs(samples).max() == pytest.approx(NORMAL_PEAK, rel=0.01)  # the largest may stand in a fade
    assert made.gain == pytest.approx(NORMAL_PEAK / 0.02, rel=0.02)
    assert made.normalised
    assert made.limited == 0


def test_the_peak_is_that_of_what_is_heard_after_the_fades():
    t = np.arange(2000) / 1000
    cut = Signal(np.sin(2 * np.pi * 200 * t)[None], 1000.0, "m/s^2")  # resampling overshoots at its ends

    assert np.abs(read(sound_of(cut).wav)[0]).max() == pytest.approx(NORMAL_PEAK, rel=1e-4)


def test_a_file_for_listening_is_of_16_bit_at_48_khz_and_normalised():
    weak = Signal(tone(1e-5, axes=3).samples, 40.0, "m", tuple("xyz"), "displacement")
    clip = sound_of(weak, subtype="PCM_16")

    info = soundfile.info(io.BytesIO(clip.wav))
    assert (info.samplerate, info.subtype, info.channels) == (48_000, "PCM_16", 1)
    assert np.abs(read(clip.wav)[0]).max() == pytest.approx(NORMAL_PEAK, rel=0.01)
    said = sound_text(weak)
    assert "played at 100 mm/s" in said
    assert "combined into one channel" in said
    assert "after 60 s" in sound_text(tone(1.0, rate=10.0, seconds=61.0))
    assert sound_text(tone(1.0)) == "is for listening alone: it loses its strength"


def test_at_a_common_gain_strengths_keep_their_ratio():
    weak, strong = tone(0.1), tone(0.4)
    gain = common_gain([0.1, 0.4])

    peaks = [np.abs(read(sound_of(signal, gain=gain).wav)[0][4000:-4000]).max() for signal in (weak, strong)]

    assert peaks[1] / peaks[0] == pytest.approx(4.0, rel=1e-3)
    assert peaks[1] == pytest.approx(NORMAL_PEAK, rel=0.01)


@pytest.mark.parametrize("axes", [2, 3, 5])
def test_axes_add_up_to_their_power(axes):
    samples, _ = read(sound_of(tone(0.1, axes=axes), gain=1.0).wav)

    assert samples[4000:-4000].std() == pytest.approx(0.1 * np.sqrt(axes / 2), rel=0.01)


def test_what_is_too_loud_is_limited_and_said():
    made = sound_of(tone(3.0), gain=1.0)

    assert np.abs(read(made.wav)[0]).max() <= 1
    assert 0.5 < made.limited < 1
    assert not made.normalised


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=50))
def test_the_limiter_keeps_order_sign_and_what_is_below_the_knee(values):
    x = np.sort(np.array(values))

    y, _ = soft_limited(x)

    assert np.all(np.abs(y) <= 1)
    assert np.all(np.diff(y) >= 0)
    assert np.array_equal(y[np.abs(x) <= KNEE], x[np.abs(x) <= KNEE])


def test_the_ends_are_faded():
    samples, _ = read(sound_of(Signal(np.tile([1.0, -1.0], 500)[None], 1000.0, "V")).wav)

    assert samples[0] == 0
    assert abs(samples[-1]) < 1e-3


def test_silence_is_silence():
    made = sound_of(tone(0.0))

    assert np.all(read(made.wav)[0] == 0)
    assert made.gain == 1.0


def test_over_displacement_it_is_walked_through():
    signal = Signal(np.random.default_rng(0).normal(size=(1, 500)), 10.0, "1", domain="displacement")

    samples, _ = read(sound_of(signal).wav)

    assert len(samples) == RATE // 2  # 50 mm at 100 mm/s


@pytest.mark.parametrize("gain", [0.0, -1.0, float("nan"), float("inf")])
def test_a_gain_that_is_none_is_refused(gain):
    with pytest.raises(ParameterError, match="gain must be > 0"):
        sound_of(tone(0.1), gain=gain)


@pytest.mark.parametrize(
    ("asked", "status", "span", "sent"),
    [
        (None, 200, None, DATA),
        ("bytes=0-1", 206, "bytes 0-1/10", DATA[:2]),  # Safari's first
        ("bytes=7-", 206, "bytes 7-9/10", DATA[7:]),
        ("bytes=4-99", 206, "bytes 4-9/10", DATA[4:]),
        ("bytes=-3", 206, "bytes 7-9/10", DATA[7:]),
        ("bytes=-99", 206, "bytes 0-9/10", DATA),
        ("bytes=10-", 416, "bytes */10", b""),
        ("bytes=-0", 416, "bytes */10", b""),
        ("bytes=5-2", 200, None, DATA),
        ("bytes=0-1,4-5", 200, None, DATA),
        ("bytes=-", 200, None, DATA),
        ("lines=0-1", 200, None, DATA),
    ],
)
def test_one_range_of_bytes_is_answered_as_rfc_9110_has_it(asked, status, span, sent):
    answer = range_response(DATA, asked, media_type="audio/wav", headers={"cache-control": "private"})
    assert (answer.status_code, answer.body) == (status, sent)
    assert answer.headers.get("content-range") == span
    assert answer.headers["content-length"] == str(len(sent))
    assert (answer.headers["accept-ranges"], answer.headers["cache-control"]) == ("bytes", "private")
