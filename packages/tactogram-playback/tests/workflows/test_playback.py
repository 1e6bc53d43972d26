import json
import os
import signal
import threading

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import DeviceError, ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram_playback.workflows.actuators import play
from tactogram_playback.workflows.playback import Playback, full_scale_of, outputs

AUDIO = open_display("audio")


def made(display=AUDIO, seconds=0.3, peak="peak=0.8"):
    """Return the drive of a vibration at 120 Hz."""
    t = np.arange(round(seconds * 8000)) / 8000
    return fit(
        Signal(np.sin(2 * np.pi * 120 * t).astype(np.float32), 8000, "m/s^2"),
        display,
        level=parse_level(peak),
    ).signal


def pulled(playing, frames=480, blocks=200):
    """Return what a device would get, shape (channel, time), until the playback says that it is over."""
    out = []
    for _ in range(blocks):
        out.append(playing.pull(frames).T)
        if playing._over.is_set():
            break
    return np.concatenate(out, axis=1)


def test_what_is_sent_is_the_drive_but_for_the_guards_fade():
    drive = made()
    sent = pulled(Playback(drive, AUDIO, strength=1.0))[:, : len(drive)]
    inner = slice(2000, len(drive) - 2000)
    error = sent[:, inner] - drive.samples[:, inner]
    # The guard's high-pass of 5 Hz turns 120 Hz by 2.4 degrees.
    assert np.sqrt((error**2).mean() / (drive.samples[:, inner] ** 2).mean()) < 0.06
    assert np.abs(sent).max() <= np.abs(drive.samples).max() * 1.01


def test_a_pads_coils_are_channels_3_and_4_of_its_card():
    pad = open_display("dualsense")
    sent = pulled(Playback(made(pad), pad, strength=1.0))
    front = pulled(Playback(made(AUDIO), AUDIO, strength=1.0))
    assert sent.shape == (4, front.shape[1])
    np.testing.assert_array_equal(sent[:2], 0)
    np.testing.assert_array_equal(sent[2:], front)
    assert np.abs(sent[2:]).max() == pytest.approx(0.8, rel=0.01)


def test_the_pads_drive_plays_on_the_null_device():
    pad = open_display("dualsense")
    assert Playback(made(pad, seconds=0.1), pad).run()["state"] == "ended"


def test_a_share_is_weaker_and_a_change_glides():
    drive = made(seconds=2.0)
    playing = Playback(drive, AUDIO, strength=0.25)
    weak = np.abs(np.concatenate([playing.pull(480) for _ in range(40)])).max()
    playing.strength = 1.0
    next_block = np.abs(playing.pull(480)).max()
    strong = np.abs(np.concatenate([playing.pull(480) for _ in range(80)])).max()
    assert weak == pytest.approx(0.2, rel=0.05)
    assert next_block < 0.3
    assert strong == pytest.approx(0.8, rel=0.05)


def test_a_stop_fades_to_rest():
    playing = Playback(made(seconds=2.0), AUDIO, strength=1.0)
    for _ in range(20):
        playing.pull(480)
    playing.stop()
    tail = pulled(playing)
    assert playing._over.is_set()
    assert np.abs(np.diff(tail)).max() < 0.1
    assert tail[:, -1] == pytest.approx(np.zeros(len(AUDIO.channels)), abs=1e-6)
    assert playing.seconds < 0.3


def test_the_null_device_plays_all_of_it_and_says_what():
    drive = made(seconds=0.3)
    playing = Playback(drive, AUDIO, strength=0.5)
    facts = playing.run()
    assert (facts["state"], facts["simulated_device"], facts["strength"]) == ("ended", True, 0.5)
    assert facts["seconds"] == pytest.approx(0.3, abs=0.02)
    assert facts["sha256"] == drive.sha256


def test_a_loop_is_as_long_as_asked():
    assert Playback(made(), AUDIO, loop_s=1.5).total_s == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("name", "device", "why"),
    [
        ("string-tablet", "audio", "driven in N"),
        ("phone", "audio", "strengths"),
        ("ultrasonic", "null", "500000"),
        ("voice-coil", "audio", "`full_scale`"),
    ],
)
def test_what_a_sound_card_cannot_play_is_said(name, device, why):
    with pytest.raises(ParameterError, match=why):
        full_scale_of(open_display(name), device)


def test_a_full_scale_below_the_drives_peak_is_refused():
    display = open_display("voice-coil")
    with pytest.raises(ParameterError, match="render it weaker"):
        Playback(made(display), display, full_scale=0.5)


def test_a_drive_of_another_display_is_refused():
    with pytest.raises(ParameterError, match="no drive of voice-coil"):
        Playback(made(), open_display("voice-coil"))


def test_a_card_that_is_not_there_is_an_error_in_a_sentence():
    playing = Playback(made(), AUDIO, device="audio:no such card")
    with pytest.raises(DeviceError, match="no sound card"):
        playing.run()
    assert playing.state == "failed"


def test_the_null_device_is_among_the_outputs():
    found = {output["device"]: output for output in outputs()}
    assert found["null"]["simulated"]
    assert found["null"]["missing"] is None


def test_the_command_line_plays_a_file(tmp_path, capsys):
    write_signal(tmp_path / "drive.npz", made(seconds=0.1))
    code = main(
        [
            "play",
            str(tmp_path / "drive.npz"),
            "--display",
            "audio",
            "--device",
            "null",
            "--strength",
            "0.3",
            "--json",
        ]
    )
    assert code == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["state"], facts["strength"]) == ("ended", 0.3)
    assert facts["sha256"] == play(tmp_path / "drive.npz", display="audio", device="null")["sha256"]


def test_an_interrupted_playback_is_waited_for_until_it_has_faded(tmp_path, monkeypatch):
    def run(playing):
        threading.Event().wait(0.05)
        os.kill(os.getpid(), signal.SIGINT)
        assert playing._stop.wait(60)
        threading.Event().wait(0.02)
        return {"faded": True}

    monkeypatch.setattr(Playback, "run", run)
    write_signal(tmp_path / "drive.npz", made())
    # Ignored, where a shell began the tests with &.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert play(tmp_path / "drive.npz", display="audio", device="null")["faded"]
    finally:
        signal.signal(signal.SIGINT, before)
