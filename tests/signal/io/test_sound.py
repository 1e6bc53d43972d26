"""Sound files."""

import struct

import numpy as np
import pytest
import soundfile
from hypothesis import given, settings, strategies as st
from tests.signal.io.sample_files import XYZ, X, noise, refusal, wav

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_file, read_metadata, read_signal, write_signal
from tactogram.signal.io.sound import read_header


def test_a_truncated_wav_names_the_byte(tmp_path):
    path = wav(tmp_path)
    path.write_bytes(path.read_bytes()[:-40])
    assert refusal(path).startswith("truncated: chunk 'data' at byte ")


def test_a_wav_without_samples_or_chunks_is_refused(tmp_path):
    path = tmp_path / "a.wav"
    soundfile.write(path, np.zeros(0), 1000)
    assert refusal(path).startswith("no samples")
    path.write_bytes(b"RIFF\4\0\0\0WAVE")
    assert refusal(path) == "truncated: no fmt chunk before the end at byte 12"


def test_no_channels_are_refused(tmp_path):
    path = wav(tmp_path, subtype="PCM_16")
    raw = bytearray(path.read_bytes())
    raw[22:24] = struct.pack("<H", 0)
    path.write_bytes(raw)
    assert refusal(path) == "channels must be > 0, got 0 at byte 22"


@pytest.mark.parametrize(("value", "text"), [(np.nan, "nan"), (np.inf, "inf"), (-np.inf, "-inf")])
def test_a_wav_that_is_not_finite_names_the_byte(tmp_path, value, text):
    x = np.zeros((100, 2), np.float32)
    x[7, 1] = value
    soundfile.write(tmp_path / "a.wav", x, 1000, "FLOAT")
    raw = (tmp_path / "a.wav").read_bytes()
    byte = raw.index(b"data") + 8 + 4 * (7 * 2 + 1)
    line = refusal(tmp_path / "a.wav")
    assert line == f"axis 1, sample 7 (byte {byte}): expected a finite number, got {text}"


def test_a_wav_that_was_resampled_elsewhere_is_refused(tmp_path):
    path = tmp_path / "a.wav"
    write_signal(path, Signal(np.ones(9), 333.3, "N"))
    raw = bytearray(path.read_bytes())
    raw[24:28] = struct.pack("<I", 44100)
    path.write_bytes(raw)
    assert refusal(path).startswith(
        "changed after it was described: described as 333.3 Hz, 1 channels, its header"
    )


@pytest.mark.parametrize("subtype", ["PCM_U8", "PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
@pytest.mark.parametrize("channels", [1, 2, 3, 7])
def test_wav_of_others(tmp_path, subtype, channels):
    x = 0.9 * np.stack([np.sin(np.arange(50) + c) for c in range(channels)])
    form = "WAVEX" if channels > 2 else "WAV"
    soundfile.write(tmp_path / "a.WAV", x.T, 22050, subtype, format=form)
    signal = read_signal(tmp_path / "a.WAV")
    bits = {"PCM_U8": 8, "PCM_16": 16}.get(subtype, 24)
    np.testing.assert_allclose(signal.samples, x, atol=1.01 / 2 ** (bits - 1))
    assert (signal.rate, signal.unit, len(signal.axes)) == (22050, "1", channels)


def test_a_wav_is_given_what_it_does_not_say(tmp_path):
    soundfile.write(tmp_path / "a.wav", np.stack([X, -X], axis=1), 333, "DOUBLE")
    signal = read_signal(tmp_path / "a.wav", unit="g", axes=("x", "z"), rate=333.3, full_scale=2)
    assert (signal.rate, signal.unit, signal.axes) == (333.3, "m/s^2", ("x", "z"))
    np.testing.assert_allclose(signal.samples[0], 2 * 9.80665 * X, rtol=1e-6)


def test_the_comment_of_others_is_metadata(tmp_path):
    for name in ("a.wav", "a.flac"):
        with soundfile.SoundFile(tmp_path / name, "w", 1000, 1, "PCM_16") as file:
            file.comment = "third take"
            file.write(X)
        assert read_metadata(tmp_path / name) == {"comment": "third take"}
        assert read_file(tmp_path / name).metadata == {"comment": "third take"}


INTEGERS = [(".wav", "PCM_U8", 8), (".wav", "PCM_16", 16), (".wav", "PCM_24", 24), (".wav", "PCM_32", 32)]


@pytest.mark.parametrize(("suffix", "subtype", "bits"), INTEGERS)
@given(level=st.floats(1e-9, 1e9), seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=15)
def test_integers_keep_level_and_never_clip(tmp_path_factory, suffix, subtype, bits, level, seed):
    path = tmp_path_factory.mktemp("a") / f"a{suffix}"
    signal = Signal(level * np.random.default_rng(seed).normal(size=(2, 50)), 1000, "m/s^2", ("x", "y"))
    write_signal(path, signal, subtype=subtype)
    back = read_signal(path)
    peak = np.abs(signal.samples).max()
    step = peak / (2 ** (bits - 1) - 1)
    assert soundfile.info(path).subtype == subtype
    assert np.abs(back.samples - signal.samples).max() <= 0.51 * step + 1e-7 * peak


@pytest.mark.parametrize(("suffix", "subtype", "bits"), INTEGERS)
def test_integers_that_were_read_are_written_the_same(tmp_path, suffix, subtype, bits):
    steps = np.random.default_rng(0).integers(-(2 ** (bits - 1)), 2 ** (bits - 1), 300) // 256 * 256
    steps = np.clip(steps, -(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    signal = Signal(steps / 2 ** (bits - 1), 44100, "1")
    write_signal(tmp_path / f"a{suffix}", signal, subtype=subtype)
    np.testing.assert_array_equal(read_signal(tmp_path / f"a{suffix}").samples, signal.samples)


def test_silence_is_an_integer_too(tmp_path):
    write_signal(tmp_path / "a.wav", Signal(np.zeros(10), 1000, "N"), subtype="PCM_16")
    assert not read_signal(tmp_path / "a.wav").samples.any()


def test_wav_is_float_by_default_and_readable_by_others(tmp_path):
    signal = noise(1, rate=1000.0)
    write_signal(tmp_path / "a.wav", signal)
    samples, rate = soundfile.read(tmp_path / "a.wav", dtype="float32")
    assert soundfile.info(tmp_path / "a.wav").subtype == "FLOAT"
    assert rate == 1000
    np.testing.assert_array_equal(samples, signal.samples[0])
    assert read_header(tmp_path / "a.wav").size == 4 * len(signal)


@pytest.mark.parametrize(
    ("axes", "subtype", "code"), [(1, "PCM_16", 1), (2, "FLOAT", 3), (3, "FLOAT", 0xFFFE)]
)
def test_many_channels_are_extensible(tmp_path, axes, subtype, code):
    write_signal(tmp_path / "a.wav", noise(axes), subtype=subtype)
    raw = (tmp_path / "a.wav").read_bytes()
    assert struct.unpack_from("<H", raw, raw.index(b"fmt ") + 8) == (code,)
    assert struct.unpack_from("<I", raw, 4) == (len(raw) - 8,)


def test_the_full_scale_that_is_asked_for_is_kept(tmp_path):
    signal = Signal([0.5, -19.0, 3.0], 1000, "m/s^2")
    write_signal(tmp_path / "a.wav", signal, subtype="PCM_16", full_scale=20)
    assert soundfile.read(tmp_path / "a.wav", dtype="int16")[0].tolist() == [819, -31130, 4915]
    np.testing.assert_allclose(read_signal(tmp_path / "a.wav").samples, signal.samples, atol=20 / 2**16)


SOUNDS = {
    ".aiff": ("AIFF", "PCM_16"), ".au": ("AU", "PCM_16"), ".caf": ("CAF", "PCM_16"), ".w64": ("W64", "FLOAT"),
    ".rf64": ("RF64", "PCM_24"), ".ogg": ("OGG", "VORBIS"), ".opus": ("OGG", "OPUS"), ".mp3": ("MP3", "MPEG_LAYER_III"),
}  # fmt: skip


@pytest.mark.parametrize("suffix", SOUNDS)
def test_sounds_of_others_are_read(tmp_path, suffix):
    form, subtype = SOUNDS[suffix]
    wave = 0.5 * np.sin(2 * np.pi * 250 * np.arange(24000) / 48000)
    soundfile.write(tmp_path / f"a{suffix}", wave, 48000, subtype, format=form)
    signal = read_signal(tmp_path / f"a{suffix}")
    assert (signal.rate, signal.unit, len(signal)) == (48000, "1", 24000)
    np.testing.assert_allclose(signal.samples[0, 4000:20000], wave[4000:20000], atol=0.02)


@pytest.mark.parametrize("suffix", [".aiff", ".au", ".caf", ".w64", ".rf64", ".mp3"])
def test_a_sound_that_is_cut_off_is_refused(tmp_path, suffix):
    form, subtype = SOUNDS[suffix]
    soundfile.write(tmp_path / f"a{suffix}", np.tile(XYZ[:2], 50).T / 2, 48000, subtype, format=form)
    raw = (tmp_path / f"a{suffix}").read_bytes()
    (tmp_path / f"a{suffix}").write_bytes(raw[: 2 * len(raw) // 3])
    with pytest.raises(DataError, match="truncated|damaged"):
        read_signal(tmp_path / f"a{suffix}")


def test_a_sound_of_a_phone_says_how_to_convert_it(tmp_path):
    (tmp_path / "a.m4a").write_bytes(b"\0\0\0\x20ftypM4A ")
    with pytest.raises(ParameterError, match="convert it to .wav, e.g. `ffmpeg -i a.m4a a.wav`"):
        read_signal(tmp_path / "a.m4a")
