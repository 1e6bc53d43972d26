"""Stimuli that follow the finger: positions from a page in, the drive of every kind of display out, the log between.

The devices are simulated, and the finger's positions are replayed on a clock of samples, so that nothing depends on how
fast this machine is.
"""

import contextlib
import json
import threading

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import tactogram_playback
from tactogram.rendering.drive.electrovibration import friction
from tactogram.rendering.families.tablet import directions
from tactogram.rendering.motion.finger_state import MotionSample
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram_playback.streaming.backends import run_unpaced
from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.simulation import TransducerSimulation
from tactogram_playback.workflows import session
from tactogram_studio.server.guard import RequestGuard
from tactogram_studio.server.guard_rules import GuardSettings
from tactogram_study.participants.routes import make_participant_app

CYCLES_PER_MM = 0.5


SLOW, FAST = 100.0, 200.0


STROKE_S = 0.5


class Replay:
    """A source of motion that arrives as soon as the page sends it."""

    name, simulated = "page", False

    def __init__(self, samples):
        self.samples = [
            MotionSample(ms / 1e3, ms / 1e3, x, y, force_n=0.5 * down) for ms, x, y, down in samples
        ]

    def poll(self, now_s):
        due = [sample for sample in self.samples if sample.time_s <= now_s]
        self.samples = self.samples[len(due) :]
        return due

    def close(self):
        pass


@pytest.fixture
def outputs(monkeypatch):
    """Replay each stream once the finger has left it, and give what a simulated device makes of it at the finger."""
    found = []

    def run(running, backend, *, seconds, clock):
        left, stop = threading.Event(), running.stop
        running.stop = lambda: (stop(), left.set())
        assert running.stopped or left.wait(60)
        running.stopped = False
        samples = [sample for _, sample in running.engine.motion._waiting]
        running.engine.motion = Replay(samples)
        device = DEVICES[running.output.display.family](running)
        run_unpaced(running, seconds=samples[-1][0] / 1e3 + 0.2 if samples else 0.5, sink=device)
        running.stopped = True
        found.append((running.engine.rate, np.concatenate(device.felt)))
        return {"device": {"library": "simulated"}}

    monkeypatch.setattr(tactogram_playback, "run", run)
    monkeypatch.setattr(session, "REHEARSAL_S", 1.0)
    return found


class Strings:
    """Motors that pull with the tensions: the force on the finger along the stroke, N."""

    def __init__(self, running):
        self.felt, self.running = [], running

    def __call__(self, block, now_s):
        motion, settings = self.running.engine.tracker.block, self.running.output.display.settings
        finger = np.stack([motion.x_mm[: motion.count], motion.y_mm[: motion.count]])
        pull = directions(settings, np.array(settings.finger_mm)[:, None] + finger)
        self.felt.append(np.einsum("st,st->t", pull[0], block))


class Transducer:
    """A generator, an amplifier and a touched transducer: the amplitude of its vibration (motional current, A)."""

    def __init__(self, running):
        settings = running.output.display.settings
        self.felt, self.gain = [], settings.amplifier_gain
        self.circuit = TransducerSimulation(
            PRESETS["finger"], rate=running.engine.rate, carrier_hz=PRESETS["finger"].resonance_hz
        )

    def __call__(self, block, now_s):
        motional, _ = self.circuit.process(self.gain * block[0])
        self.felt.append(np.abs(motional))


class Electrode:
    """A finger on a surface that attracts it: the friction coefficient, by the square law."""

    def __init__(self, running):
        self.felt, self.settings = [], running.output.display.settings

    def __call__(self, block, now_s):
        volts = np.abs(block[0]) * self.settings.amplifier_gain / np.sqrt(2)
        self.felt.append(friction(volts, self.settings))


class Card:
    """A sound card."""

    def __init__(self, running):
        self.felt = []

    def __call__(self, block, now_s):
        self.felt.append(block[0].copy())


DEVICES = {"tablet": Strings, "ultrasonic": Transducer, "electrovibration": Electrode, "linear": Card}


def grating(unit="m/s^2"):
    """A grating of 2 mm, recorded at 100 mm/s; as a friction coefficient over displacement."""
    place = np.arange(0, 100, 0.05)
    if unit == "1":
        mu = 0.4 + 0.05 * np.sin(2 * np.pi * CYCLES_PER_MM * place)
        return Signal(mu.astype(np.float32), 20.0, "1", domain="displacement")
    return Signal(np.sin(2 * np.pi * CYCLES_PER_MM * place).astype(np.float32), 2000.0, unit)


def stimuli(folder, signal):
    write_signal(folder / "grating.npz", signal)
    speed = {} if signal.domain == "displacement" else {"speed_mm_s": 100.0}
    both = [
        {"name": f"g/{version}", "item": "g", "condition": version} for version in ("recorded", "generated")
    ]
    return [one | speed | {"file": "grating.npz"} for one in both]


def strokes():
    """Two strokes at a constant speed each, without a pause; 100 positions a second, ten to a message."""
    t = np.arange(0, 2 * STROKE_S, 0.01)
    x = np.where(t < STROKE_S, SLOW * t, SLOW * STROKE_S + FAST * (t - STROKE_S)) - 75
    samples = [[1e3 * a, b, 0.0, 1] for a, b in zip(t.tolist(), x.tolist(), strict=True)]
    samples.append([1e3 * (t[-1] + 0.01), float(x[-1]), 0.0, 0])
    return [samples[i : i + 10] for i in range(0, len(samples), 10)]


@pytest.fixture
def finger(served_here):
    """Give a function that opens the websocket of a participant's page."""

    @contextlib.contextmanager
    def opened_socket(sessions, ticket, token):
        with (
            served_here(RequestGuard(make_participant_app(sessions), GuardSettings())) as address,
            connect(f"ws{address.removeprefix('http')}/take/{ticket}/finger?token={token}") as socket,
        ):
            yield socket

    return opened_socket


@pytest.fixture
def stroked(finger):
    def stroke(sessions, one, page, slot, messages):
        """Send a finger's positions to a slot of a page, and leave it."""
        with finger(sessions, one.ticket, page["token"]) as socket:
            for samples in messages:
                socket.send(json.dumps({"slot": slot, "samples": samples}))

    return stroke


def strongest_hz(signal, rate):
    power = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(len(signal)), 8 * len(signal)))
    return np.argmax(power) * rate / (8 * len(signal))


@pytest.mark.parametrize(
    ("display", "level", "unit", "lag_s"),
    [
        ("string-tablet", "gain=0.3", "m/s^2", 0.05),
        ("ultrasonic-envelope", "gain=0.5", "m/s^2", 0.02),
        ("electrovibration", "physical", "1", 0.02),
        ("audio", "peak=0.5", "m/s^2", 0.02),
    ],
)
def test_the_finger_is_followed_on_every_kind_of_display(
    tmp_path, opened, person, outputs, stroked, until, display, level, unit, lag_s
):
    made = {"display": display, "level": level, "stimuli": stimuli(tmp_path, grating(unit))}
    sessions, session, client = opened(tmp_path, played_by="stream", **made)
    one = person(client, session.join_path)
    page = one.go_to("abx")
    stroked(sessions, one, page, "A", strokes())
    until(lambda: any(row["facts"] for row in session.store.played_log(one.code)))
    [(rate, felt)] = outputs
    slow = felt[int((0.15 + lag_s) * rate) : int(STROKE_S * rate)]
    fast = felt[int((STROKE_S + 0.1 + lag_s) * rate) : int(2 * STROKE_S * rate)]
    if display == "electrovibration":  # the carrier of 10 kHz, smoothed as the skin does
        slow, fast = (np.convolve(part, np.ones(200) / 200, "valid") for part in (slow, fast))
    assert strongest_hz(slow, rate) == pytest.approx(CYCLES_PER_MM * SLOW, rel=0.1)
    assert strongest_hz(fast, rate) == pytest.approx(CYCLES_PER_MM * FAST, rel=0.1)
    assert np.abs(felt[-int(0.02 * rate) :] - felt[-1]).max() < 1e-3 * np.ptp(felt)  # at rest in the end

    [played] = session.store.played_log(one.code)
    assert (played["token"], played["slot"], played["level"]) == (page["token"], "A", level)
    assert played["display"] == display
    facts = played["facts"]
    assert facts["simulated_device"] is True
    assert facts["display"]["drive_rms"] > 0
    assert facts["motion"]["used"] == sum(map(len, strokes()))
    assert 5 <= facts["latency"]["total"]["p50_ms"] < 100
    assert facts["latency"]["age"]["count"] > 0
    assert facts["states"]["slide"] > 0.7


def test_silence_keeps_the_display_at_rest(tmp_path, opened, person, outputs, stroked, until):
    one_of = {"display": "string-tablet", "level": "gain=0.3", "stimuli": stimuli(tmp_path, grating())[:1]}
    sessions, session, client = opened(tmp_path, design="staircase", played_by="stream", **one_of)
    one = person(client, session.join_path)
    page = one.go_to("staircase")
    for slot in "AB":
        stroked(sessions, one, page, slot, strokes())
        until(lambda: session.store.played_log(one.code)[-1]["facts"])
    silent = [log["facts"]["silent"] for log in session.store.played_log(one.code)]
    assert sorted(silent) == [False, True]
    assert [float(np.ptp(felt)) > 0 for _, felt in outputs] == [not quiet for quiet in silent]


def test_what_cannot_be_streamed_is_told_once_per_touch(tmp_path, opened, person, finger):
    sessions, session, client = opened(tmp_path)  # played in the browser
    one = person(client, session.join_path)
    page = one.go_to("abx")
    touch = {"slot": "A", "samples": [[0, 0, 0, 1]]}
    with finger(sessions, one.ticket, page["token"]) as socket:
        for _ in range(3):
            socket.send(json.dumps(touch))
        told = json.loads(socket.recv(5))
        socket.send(json.dumps(touch | {"slot": "B"}))
        assert (told["slot"], told["state"]) == ("A", "failed")
        assert "does not follow the finger" in told["error"]
        assert told["status"] == 400
        assert json.loads(socket.recv(5))["slot"] == "B"
        socket.send(json.dumps({"slot": "A", "samples": [["x"]]}))
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(5)
    assert closed.value.rcvd.code == 1003
    with pytest.raises(InvalidStatus), finger(sessions, "nobody", page["token"]):
        pass
