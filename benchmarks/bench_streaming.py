"""Benchmark of streaming under a simulated hand: time per block by number of simultaneous textures.

Textures are made up, one axis, at 8 kHz like the stream ("to another rate": at 2.5 kHz): autoregressive of order 60 on
tables of 17 speeds by 9 forces, or modulated noise ("noise") on 33 by 3. Blocks of 5 ms, a linear display with an
equaliser of 2,000 taps, 20 s each on the null device of miniaudio, which keeps a sound card's pace. "wall" is by the
clock, "processor" what the thread had of a processor. "share" is the wall's p99 over the block: below 1 is the goal, at
10 textures. "real time": with the system's real-time priority, where it was granted. Repetitions of a row go one after
the other; "load" is the machine's load average at the beginning: above the number of cores, wall times and underruns
are those of a busy machine.
"""

from __future__ import annotations

import os

import numpy as np

from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.level import parse_level
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.texture_map import NoiseMap, TextureMap
from tactogram_playback.streaming.backends import Clock, run_miniaudio, run_unpaced
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.output import DisplayOutput, Stream
from tactogram_playback.workflows.textures import TextureSettings, texture_of_map

RATE, MOST = 8000.0, 40
ORDER = 60
SECONDS = 20.0
CASES = (
    ("autoregressive", 1, 8000.0, False, 2),
    ("autoregressive", 10, 8000.0, False, 3),
    ("autoregressive", 10, 8000.0, True, 3),
    ("autoregressive", 10, 2500.0, True, 1),
    ("autoregressive", 40, 8000.0, True, 1),
    ("noise", 1, 8000.0, False, 1),
    ("noise", 10, 8000.0, False, 2),
    ("noise", 10, 8000.0, True, 2),
    ("noise", 10, 2500.0, True, 1),
)
"""Kind of textures, their number and rate, whether real-time priority is asked for, repetitions."""


def run():
    display = open_display("voice-coil")
    surfaces = {"autoregressive": made_up, "noise": made_up_noise}
    tables = {(kind, rate): surfaces[kind](rate) for kind, _, rate, _, _ in CASES}
    rows = []
    for kind, count, rate, realtime, repetitions in CASES:
        for repetition in range(repetitions):
            load = os.getloadavg()[0]
            latency, granted = streamed(tables[kind, rate], count, display, realtime)
            block = latency["block_ms"]
            rows.append(
                {
                    "kind": kind,
                    "textures": count,
                    "to another rate": "" if rate == RATE else "yes",
                    "real time": "yes" if granted else "asked, refused" if realtime else "no",
                    "repetition": repetition + 1,
                    "wall p50 ms": latency["compute"]["p50_ms"],
                    "wall p99 ms": latency["compute"]["p99_ms"],
                    "wall max ms": latency["compute"]["max_ms"],
                    "processor p99 ms": latency["processor"]["p99_ms"],
                    "share": latency["compute"]["p99_ms"] / block,
                    "motion to block's end p99 ms": latency["total"]["p99_ms"],
                    "underruns": f"{latency['underruns']} of {latency['compute']['count']}",
                    "load": round(load, 1),
                }
            )
    return rows


def streamed(surface, count, display, realtime):
    """Return what a stream measured of itself, and whether it had real-time priority."""
    level = parse_level("gain=1")
    tried = Stream(engine(surface, count, SimulatedHand(3, seed=1)), record_s=2.0)
    run_unpaced(tried, seconds=2.0)
    output = DisplayOutput(display, Signal(tried.recorded, RATE, "m/s^2"), level=level)
    stream = Stream(engine(surface, count, SimulatedHand(SECONDS + 1, seed=0)), output)
    stream.warm_up()
    device = run_miniaudio(stream, seconds=SECONDS, clock=Clock(), null=True, realtime=realtime)
    return stream.facts()["latency"], device["realtime_priority"]


def engine(surface, count, hand):
    settings = TextureSettings(RATE, MOST)
    textures = [texture_of_map(f"texture {n}", surface, settings, seed=n) for n in range(count)]
    return Engine(textures, hand, rate=RATE, most=MOST)


def made_up_noise(rate):
    """Return a surface of modulated noise whose beat and strength go up with speed and force."""
    random = np.random.default_rng(0)
    models, conditions = [], []
    for speed in (25.0, 50.0, 100.0, 200.0, 400.0):
        for force in (0.2, 0.6, 1.2):
            t = np.arange(round(2 * rate)) / rate
            beat = 1 + 0.9 * np.sin(2 * np.pi * speed / 20 * t)
            x = (1 + force) * beat * random.standard_normal(t.size)
            models.append(fit_modulated_noise(Signal(x, rate, "m/s^2", ("z",))))
            conditions.append((speed, force))
    return NoiseMap(models, conditions)


def made_up(rate):
    """Return a surface whose peaks move up with the speed; the order is that of real recordings."""
    random = np.random.default_rng(0)
    base = np.tanh(random.normal(0, 0.15, ORDER))
    models, conditions = [], []
    for speed in (25.0, 50.0, 100.0, 200.0, 400.0):
        for force in (0.2, 0.6, 1.2):
            reflection = base.copy()
            reflection[:2] = -0.98 * np.cos(2 * np.pi * min(2 * speed, 0.4 * rate) / rate), 0.96
            flat = AutoregressiveModel(reflection[None], np.eye(1), rate, "m/s^2", ("z",))
            scale = (1 + force) ** 2 / flat.power[0]
            models.append(AutoregressiveModel(reflection[None], np.array([[scale]]), rate, "m/s^2", ("z",)))
            conditions.append((speed, force))
    return TextureMap(models, conditions)
