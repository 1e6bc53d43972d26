"""Textures in the browser: what the sound thread of the page Touch costs, and how late it says that it is.

Headless Chromium, no sound card. "share": of real time that the page's own worklet takes to render ten seconds at
48 kHz offline, in its blocks of 128 samples, under a simulated stroke; the median of five. Below 1 is needed, a tenth
leaves room for the rest of a page. Textures are made up: autoregressive of order 60 on tables of 17 speeds by 9 forces,
and modulated noise on 33 by 3, at 8 and at 1 kHz, and surfaces of 300 mm at 10 samples per mm. "python": the share that
`tactogram_playback.streaming` takes for the same (8 kHz blocks of 40 samples where the browser makes 48 kHz), in the
same run.

"latency": from the time stamps of mouse events, made by the test driver at about 60 Hz, to the output of the first
block that follows, as `getOutputTimestamp` tells it: with a browser that plays to nobody this is its own buffering,
not a sound card's.
"""

from __future__ import annotations

import base64
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.bench_streaming import made_up, made_up_noise
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Signal
from tactogram_playback.streaming.backends import run_unpaced
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.output import Stream
from tactogram_playback.streaming.textures import SurfaceTexture
from tactogram_playback.workflows.textures import TextureSettings, texture_of_map
from tactogram_studio.touch.tables import table_of_map, table_of_signal

RATE, SECONDS, REPETITIONS = 48_000.0, 10.0, 5
COUNTS = (1, 2, 5, 10)
MOVES = 400
ARGUMENTS = ("--no-sandbox", "--disable-gpu", "--autoplay-policy=no-user-gesture-required")

RENDER = """async ({packed, count, rate, seconds, repetitions}) => {
  const {readTable} = await import('/static/touch_textures.js');
  const {head, buffer} = readTable(await (await fetch(packed)).arrayBuffer());
  const samples = [];
  for (let t = 0; t < seconds; t += 1 / 250) {
    samples.push({time: t, x: 60 * (1 - Math.cos(3 * t)), y: 0, force: 0.6 + 0.3 * Math.sin(t)});
  }
  const shares = [];
  for (let n = 0; n <= repetitions; n++) {
    const context = new OfflineAudioContext(1, rate * seconds, rate);
    await context.audioWorklet.addModule('/static/touch_worklet.js');
    const messages = [
      {kind: 'textures', tables: Array(count).fill({head, buffer}), seed: n},
      {kind: 'output', gain: 1e-3, open: true, settled: true},
      {kind: 'script', samples},
    ];
    const options = {numberOfInputs: 0, outputChannelCount: [1], processorOptions: {messages}};
    new AudioWorkletNode(context, 'tactogram-touch', options).connect(context.destination);
    const began = performance.now();
    await context.startRendering();
    if (n > 0) shares.push((performance.now() - began) / 1e3 / seconds);  // the first one is compiled on the way
  }
  return shares;
}"""


def run():
    browser = os.environ.get("TACTOGRAM_BROWSER") or shutil.which("chromium")
    with (
        tempfile.TemporaryDirectory() as folder,
        served(Path(folder)) as address,
        sync_playwright() as playwright,
    ):
        opened = playwright.chromium.launch(executable_path=browser, args=list(ARGUMENTS))
        page = opened.new_page(base_url=address)
        rows = [*costs(page), latency(page)]
        opened.close()
    return rows


def costs(page):
    page.goto("/static/touch.html")
    surface = made_up_surface()
    kinds = {
        "autoregressive, 8 kHz": made_up(8000.0),
        "autoregressive, 1 kHz": made_up(1000.0),
        "noise, 8 kHz": made_up_noise(8000.0),
        "noise, 1 kHz": made_up_noise(1000.0),
        "surface": surface,
    }
    for kind, made in kinds.items():
        table = (
            table_of_signal(kind, made, rate=RATE) if made is surface else table_of_map(kind, made, rate=RATE)
        )
        data = "data:application/octet-stream;base64," + base64.b64encode(table.packed()).decode()
        for count in COUNTS:
            load = os.getloadavg()[0]
            asked = {
                "packed": data,
                "count": count,
                "rate": RATE,
                "seconds": SECONDS,
                "repetitions": REPETITIONS,
            }
            shares = page.evaluate(RENDER, asked)
            yield {
                "measured": "cost",
                "texture": kind,
                "textures": count,
                "share": float(np.median(shares)),
                "worst": float(max(shares)),
                "python": in_python(made, count),
                "load": round(load, 1),
            }


def in_python(made, count):
    """Return the share of real time that Python takes at 8 kHz for so many textures."""
    if isinstance(made, Signal):
        textures = [SurfaceTexture(f"{n}", made, rate=8000.0) for n in range(count)]
    else:
        settings = TextureSettings(8000.0, 40)
        textures = [texture_of_map(f"{n}", made, settings, seed=n) for n in range(count)]
    stream = Stream(Engine(textures, SimulatedHand(SECONDS + 1, seed=0), rate=8000.0, most=40))
    stream.warm_up()
    began = time.perf_counter()
    run_unpaced(stream, seconds=SECONDS)
    return (time.perf_counter() - began) / SECONDS


def latency(page):
    page.goto("/touch")
    page.wait_for_selector("#touch[data-ready=true]")
    page.click("#touch-begin")
    box = page.locator("#touch-pad").bounding_box()
    for n in range(MOVES):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.4 * np.sin(0.1 * n)), box["y"] + 100)
    late = np.array(page.evaluate("window.tactogramTouch.sound.latencies"))
    told = page.evaluate("window.tactogramTouch.sound.told()")
    counts = page.evaluate("window.tactogramTouch.report.counts")
    return {
        "measured": "latency",
        "p50 ms": float(1e3 * np.quantile(late, 0.5)),
        "p95 ms": float(1e3 * np.quantile(late, 0.95)),
        "events": len(late),
        "baseLatency ms": 1e3 * told["base"],
        "outputLatency ms": None if told["output"] is None else 1e3 * told["output"],
        "motion dropped": f"{counts['late'] + counts['out_of_order']} of {counts['used']}",
        "load": round(os.getloadavg()[0], 1),
    }


def made_up_surface():
    random = np.random.default_rng(0)
    return Signal(
        random.normal(0, 1, (1, 3000)).astype(np.float32), 10.0, "m/s^2", ("z",), domain="displacement"
    )


class served:  # noqa: N801
    """The studio on a folder, with its first surfaces made."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __enter__(self) -> str:
        command = [
            sys.executable,
            "-m",
            "tactogram",
            "studio",
            "--port",
            "0",
            "--no-open",
            "--folder",
            ".",
        ]
        self._process = subprocess.Popen(
            command, cwd=self._folder, stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        self.pid = self._process.pid
        line = next(line for line in self._process.stdout if line.startswith("studio: "))
        made = self._folder / "studio" / "first" / "voices" / "model.json"
        until = time.monotonic() + 120
        while not made.exists() and time.monotonic() < until:
            time.sleep(0.5)
        return line.removeprefix("studio: ").strip()

    def __exit__(self, *_) -> None:
        os.killpg(self._process.pid, signal.SIGTERM)
        self._process.wait(10)
        self._process.stdout.close()
