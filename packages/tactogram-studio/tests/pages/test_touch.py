import base64
import json
import math
import re
import shutil
from urllib.parse import urlencode

import numpy as np
import pytest
from PIL import Image as Pillow
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.strength import strength
from tactogram.rendering.families import pattern
from tactogram.rendering.level import parse_level
from tactogram.rendering.motion.finger_state import MotionSample, MotionSettings
from tactogram.rendering.motion.recorded_motion import SimulatedHand
from tactogram.signal import Image, Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.io import write_image, write_signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import NoiseMap, TextureMap
from tactogram.workflows.training.loaded_run import load_run
from tactogram_playback.streaming.engine import Engine
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture, NoiseTable
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import AutoregressiveTexture, SurfaceTexture
from tactogram_studio.pages.touch import parse_request
from tactogram_studio.touch.bundling import element_script
from tactogram_studio.touch.tables import rounded_parameters, table_of_map

"""The page Touch in a browser: its sound thread makes what Python's stream makes of the same motion.

Sound is rendered offline by the page's own worklet. Both sides get the same noise: the script's generator, written here
a second time.
"""


RATE, MOST = 48_000.0, 128


VOICES = "studio/first/voices"


RIDGES = "recordings/ridges.npz"


SETTINGS = MotionSettings(late_s=0.06)


"""The browser's only difference: it may hold pointer events back for longer."""


TABLES = "() => window.tactogramTouch.rows.tables().map(({head}) => ({head}))"


COUNTS = """() => {
  const {used, late, out_of_order} = window.tactogramTouch.report.counts;
  return {used, late, out_of_order};
}"""


ALL_TOLD = """(before) => {
  const {report: {counts}, pad: {track}} = window.tactogramTouch;
  const told = Object.keys(before).reduce((sum, name) => sum + counts[name] - before[name], 0);
  return told >= track.length;
}"""


"""Whether the sound thread has told of every sample of the pad's."""


RENDER = """async ({queries, rate, seconds, gain = 1, ...rest}) => {
  const {readTable} = await import('/static/touch_textures.js');
  const answers = await Promise.all(queries.map((query) => fetch(query)));
  const buffers = await Promise.all(answers.map((answer) => answer.arrayBuffer()));
  const tables = buffers.map(readTable).map(({head, buffer}) => ({head, buffer}));
  const context = new OfflineAudioContext(1, Math.round(rate * seconds), rate);
  await context.audioWorklet.addModule('/static/touch_worklet.js');
  const messages = [
    {kind: 'textures', tables, ...rest},
    {kind: 'output', gain, open: true, settled: true},
    {kind: 'script', samples: rest.samples},
  ];
  const options = {numberOfInputs: 0, outputChannelCount: [1], processorOptions: {messages}};
  new AudioWorkletNode(context, 'tactogram-touch', options).connect(context.destination);
  const bytes = new Uint8Array((await context.startRendering()).getChannelData(0).buffer);
  let text = '';
  for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  return btoa(text);
}"""


class Sfc32:
    """The script's noise: sfc32, and Box and Muller's way."""

    def __init__(self, seed):
        self.a, self.b, self.c, self.count, self.kept = 0x9E3779B9, 0x243F6A88, seed, 1, None
        for _ in range(15):
            self.whole()

    def whole(self):
        word = 0xFFFFFFFF
        total = (self.a + self.b + self.count) & word
        self.count = (self.count + 1) & word
        self.a = self.b ^ (self.b >> 9)
        self.b = (self.c + (self.c << 3)) & word
        self.c = (((self.c << 21) | (self.c >> 11)) + total) & word
        return total

    def normal(self):
        if self.kept is not None:
            kept, self.kept = self.kept, None
            return kept
        radius = math.sqrt(-2 * math.log((self.whole() + 1) / 2**32))
        angle = 2 * math.pi * self.whole() / 2**32
        self.kept = radius * math.sin(angle)
        return radius * math.cos(angle)

    def standard_normal(self, out):
        out[:] = np.reshape([self.normal() for _ in range(out.size)], out.shape)


class Script:
    """Samples that are heard when their time comes."""

    name, simulated = "script", True

    def __init__(self, samples):
        self._samples = [
            MotionSample(s["time"], s["time"], s["x"], s["y"], math.nan, s["force"]) for s in samples
        ]

    def poll(self, now_s):
        found = []
        while self._samples and self._samples[0].time_s <= now_s:
            found.append(self._samples.pop(0))
        return found

    def close(self):
        pass


def ridges(per_mm=0.5, length_mm=80.0, rate=20.0):
    place = np.arange(round(length_mm * rate)) / rate
    wave = 2 * np.sin(2 * np.pi * per_mm * place)
    return Signal(wave[None].astype(np.float32), rate, "m/s^2", ("z",), domain="displacement")


@pytest.fixture(scope="module")
def workspace(surfaces, tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio") / "workspace"
    shutil.copytree(surfaces, folder)
    write_signal(folder / RIDGES, ridges())
    return folder


@pytest.fixture(scope="module")
def voices(workspace):
    return load_run(workspace / VOICES)


@pytest.fixture
def touch(tab):
    """Give the page with the ridges on its pad."""
    tab.add_init_script("window.buzzed = []; navigator.vibrate = (what) => Boolean(window.buzzed.push(what))")
    tab.goto(f"/touch?where=file&of={RIDGES}")
    tab.wait_for_selector("#touch[data-ready=true]")
    return tab


@pytest.fixture(scope="module")
def quiet(browser, server):
    """Give one page of the studio for what is rendered offline, and fail on its errors in the end."""
    context = browser.new_context(base_url=server)
    page = context.new_page()
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda told: wrong.append(told.text) if told.type == "error" else None)
    page.goto("/static/touch.html")
    yield page
    context.close()
    assert wrong == []


def rendered(page, queries, samples, seconds, **options):
    asked = [
        query if isinstance(query, str) else "/touch/table?" + urlencode({"rate": RATE, **query})
        for query in queries
    ]
    values = {"queries": asked, "rate": RATE, "seconds": seconds, "samples": samples, "seed": 5, **options}
    return np.frombuffer(base64.b64decode(page.evaluate(RENDER, values)), "<f4")


def streamed(textures, samples, seconds, weights=None):
    """What Python's engine makes of the same motion."""
    engine = Engine(textures, Script(samples), rate=RATE, most=MOST, weights=weights, settings=SETTINGS)
    blocks = [
        engine.render(n * MOST / RATE)[0].copy() for n in range(math.ceil(round(seconds * RATE) / MOST))
    ]
    return np.concatenate(blocks)[: round(seconds * RATE)]


def texture_of(voices, material, seed):
    return noisy(material, voices.model.maps[voices.kind.materials.index(material)], seed)


def sloping():
    """Models whose peak lies at 1.5 Hz per mm/s and whose rms is 1 + force, at a rate above the browser's half."""
    conditions = [(v, f) for v in (50.0, 100.0, 200.0) for f in (0.3, 1.0)]
    models = []
    for v, f in conditions:
        polynomial = [1, -2 * 0.99 * math.cos(2 * math.pi * 1.5 * v / 2500), 0.99**2]
        flat = AutoregressiveModel.from_coefficients([polynomial], [1.0], rate=2500.0, unit="m/s^2")
        scale = (1 + f) ** 2 / flat.power[0]
        models.append(AutoregressiveModel.from_coefficients([polynomial], [scale], rate=2500.0, unit="m/s^2"))
    return TextureMap(models, conditions)


def noisy(name, surface, seed):
    """An autoregressive texture with the script's noise."""
    texture = AutoregressiveTexture(name, TextureTable(surface), rate=RATE, most=MOST, seed=0)
    noise = Sfc32(seed)
    noise.standard_normal(texture._filter.state)
    texture._random = noise
    return texture


def pulsating():
    """Modulated noise whose rms is 1 + force and whose peak, and the beat of its strength, follow the speed."""
    conditions = [(v, f) for v in (50.0, 100.0, 200.0) for f in (0.3, 1.0)]
    random, models = np.random.default_rng(0), []
    for v, f in conditions:
        x = lfilter(
            [1], [1, -1.9 * math.cos(2 * math.pi * 1.5 * v / 2500), 0.9], random.standard_normal(5000)
        )
        x *= 1 + 0.9 * np.sin(2 * np.pi * v / 20 * np.arange(5000) / 2500)
        models.append(fit_modulated_noise(Signal((1 + f) * x / x.std(), 2500.0, "m/s^2")))
    return NoiseMap(models, conditions)


def ribbed():
    """Ribs of 4 mm with three harmonics, which swell and wander, in noise."""
    random, models = np.random.default_rng(0), []
    for v in (50.0, 200.0):
        phase = 2 * np.pi * np.cumsum(v / 2 * np.exp(0.02 * np.sin(np.arange(10_000) / 400))) / 2500
        wave = sum(np.cos(k * phase) / k for k in (1, 2, 3)) * (1 + 0.1 * np.sin(np.arange(10_000) / 300))
        x = wave + 0.1 * random.standard_normal(10_000)
        models.append(fit_modulated_noise(Signal(x.astype(np.float32), 2500.0, "m/s^2")))
    return NoiseMap(models, [[50.0, np.nan], [200.0, np.nan]])


def noisy_of(surface, seed):
    """Modulated noise with the script's noise and rounded parameters."""
    table = NoiseTable(surface)
    whole, steps = rounded_parameters(table)
    table.grid = table.grid._replace(values=whole * steps)
    texture = ModulatedNoiseTexture("pulse", table, rate=RATE, most=MOST, seed=0)
    texture._process._innovations = texture._process._noise = Sfc32(seed)
    texture._process._tones._random = Sfc32(seed ^ 0x746F6E65)
    return texture


def surface_of(along="path"):
    texture = SurfaceTexture("ridges", ridges(), rate=RATE, along=along)
    texture.holds_at_rest = False
    return texture


def a_hand(seconds, seed=3):
    """Strokes, rests, lifts and landings; position and force come apart."""
    return [
        {"time": s.time_s, "x": s.x_mm, "y": s.y_mm, "force": s.force_n}
        for s in SimulatedHand(seconds, seed=seed).poll(seconds)
    ]


def a_stroke(speed, seconds, *, force=0.6, rate=250):
    times = np.arange(round(seconds * rate)) / rate
    return [{"time": t, "x": speed * t, "y": 0.0, "force": force} for t in times.tolist()]


def peak_hz(samples):
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples))))
    return float(np.argmax(spectrum) * RATE / len(samples))


FILE = {"where": "file", "of": RIDGES}


TILE = {"where": "run", "of": VOICES, "material": "tile", "lay": "table"}


GRASS = {**TILE, "material": "artificial-grass"}


def test_the_sound_thread_makes_the_samples_that_rendering_makes(quiet, voices):
    """Filtered noise, surfaces by way and by place, and a mix, under a hand that strokes, lifts and lands."""
    hand = a_hand(2.5)
    for queries, textures, options in (
        ([TILE], [texture_of(voices, "tile", 5)], {}),
        ([FILE], [surface_of()], {}),
        ([{**FILE, "lay": "x"}], [surface_of("x")], {}),
        (
            [TILE, GRASS],
            [texture_of(voices, "tile", 5), texture_of(voices, "artificial-grass", 6)],
            {"fields": [[0.75, 0.25]]},
        ),
    ):
        names = [texture.name for texture in textures]
        weights = dict(zip(names, options["fields"][0], strict=True)) if options else None
        expected = streamed(textures, hand, 2.5, weights)
        # No limit comes in: 0.89 of full scale would be far above.
        found = rendered(quiet, queries, hand, 2.5, gain=1e-3, **options) / 1e-3
        assert np.sqrt(np.mean(expected**2)) > 0.3
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max(), names


def a_ramp():
    """A stroke from 40 to 230 mm/s under a rising force: other models from block to block."""
    times = np.arange(500) / 250
    place = 40 * times + 47.5 * times**2
    return [
        {"time": t, "x": x, "y": 0.0, "force": 0.2 + 0.5 * t}
        for t, x in zip(times.tolist(), place.tolist(), strict=True)
    ]


def packed(name, surface):
    data = table_of_map(name, surface, rate=RATE).packed()
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def test_models_over_speed_and_force_are_followed_as_rendering_follows_them(quiet):
    expected = streamed([noisy("slope", sloping(), 5)], a_ramp(), 2.0)
    found = rendered(quiet, [packed("slope", sloping())], a_ramp(), 2.0, gain=1e-3) / 1e-3
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
    begins, ends = (peak_hz(found[round(a * RATE) : round(b * RATE)]) for a, b in ((0.1, 0.5), (1.6, 2.0)))
    assert begins == pytest.approx(1.5 * 68, rel=0.3)
    assert ends == pytest.approx(1.5 * 200, rel=0.15)


@pytest.mark.parametrize(
    "motion", [a_ramp(), a_hand(2.0), a_stroke(100.0, 2.0)], ids=["ramp", "hand", "steady"]
)
@pytest.mark.parametrize("texture", [pulsating, ribbed])
def test_modulated_noise_and_tones_are_those_of_rendering(quiet, motion, texture):
    surface = texture()
    expected = streamed([noisy_of(surface, 5)], motion, 2.0)
    found = rendered(quiet, [packed("pulse", surface)], motion, 2.0, gain=1e-3) / 1e-3
    assert np.sqrt(np.mean(expected**2)) > 0.3
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_what_the_pointer_does_on_the_pad_is_what_is_played(touch):
    """The mouse goes along a known path; its samples, rendered offline, are Python's stream of them."""
    touch.click("#touch-begin")
    touch.wait_for_function("window.tactogramTouch.sound.context.state === 'running'")
    box = touch.locator("#touch-pad").bounding_box()
    touch.mouse.move(box["x"] - 30, box["y"])
    touch.wait_for_function("window.tactogramTouch.report.state === 'lost'")
    before = touch.evaluate(COUNTS)
    touch.evaluate("window.tactogramTouch.pad.track.length = 0")
    path = [(box["x"] + 100 + 300 * (1 - math.cos(0.05 * n)), box["y"] + 150 + 0.5 * n) for n in range(100)]
    for place in path:
        touch.mouse.move(*place)
    touch.mouse.move(box["x"] - 30, box["y"] + 200)
    touch.wait_for_function("window.tactogramTouch.pad.track.at(-1)?.force === 0")
    touch.wait_for_function(ALL_TOLD, arg=before)
    track = touch.evaluate("window.tactogramTouch.pad.track")
    per_mm = touch.evaluate("window.tactogramTouch.pad.pxPerMm")
    border = touch.evaluate("document.getElementById('touch-pad').clientLeft")
    assert per_mm == pytest.approx(96 / 25.4)
    sent = {(round(s["x"], 6), round(s["y"], 6)) for s in track}
    wanted = [((x - box["x"] - border) / per_mm, (y - box["y"] - border) / per_mm) for x, y in path]
    near = [min(math.hypot(x - a, y - b) for a, b in sent) for x, y in wanted]
    assert np.mean(np.array(near) < 0.3) > 0.95  # a pixel is 0.26 mm; the last one of a picture may stand in
    counts = touch.evaluate(COUNTS)
    heard = {name: counts[name] - before[name] for name in before}
    assert heard["used"] > 0.5 * len(track)  # a busy machine hands some over too late to be played
    assert sum(heard.values()) == len(track)
    assert track[-1]["force"] == 0

    samples = [{**s, "time": s["time"] - track[0]["time"]} for s in track]
    seconds = samples[-1]["time"] + 0.1
    expected = streamed([surface_of()], samples, seconds)
    found = rendered(touch, [FILE], samples, seconds, gain=1e-2) / 1e-2
    assert np.abs(expected).max() > 1.0
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_pitch_and_level_follow_the_speed(quiet):
    """Half a ridge per mm: 60 mm/s are 30 Hz, 240 mm/s are 120 Hz, as strong at each; at rest there is nothing."""
    for speed in (60.0, 120.0, 240.0):
        found = rendered(quiet, [FILE], a_stroke(speed, 1.5), 1.5, gain=1e-2, tap_gain=0)[-48_000:] / 1e-2
        assert peak_hz(found) == pytest.approx(0.5 * speed, abs=1.0)
        assert np.std(found) == pytest.approx(math.sqrt(2), rel=0.02)


def test_at_rest_outside_and_muted_it_is_silent(quiet):
    stroke = a_stroke(120.0, 0.4)
    last = stroke[-1]
    rests = [{**last, "time": 0.4 + 0.01 * n} for n in range(60)]
    found = rendered(quiet, [FILE], stroke + rests, 1.0)
    assert np.abs(found[:19_200]).max() > 0.5
    assert not found[-9600:].any()
    outside = [{**last, "x": last["x"] + 1.2 * n, "time": 0.4 + 0.01 * n, "force": 0.0} for n in range(60)]
    assert not rendered(quiet, [FILE], stroke + outside, 1.0)[-9600:].any()
    assert not rendered(quiet, [FILE], [], 0.3).any()


def test_nothing_clicks_where_the_finger_lands_lifts_or_jumps(quiet):
    """No step from sample to sample is larger than the ridges' own at the greatest speed of the hand."""
    found = rendered(quiet, [FILE], a_hand(3.0, seed=4), 3.0, gain=1e-2, tap_gain=0) / 1e-2
    steepest = 2.0 * 2 * np.pi * 0.5 * 600 / RATE
    assert np.abs(np.diff(found)).max() < 1.5 * steepest


def test_nothing_gets_over_full_scale(quiet):
    found = rendered(quiet, [FILE], a_stroke(120.0, 0.6), 0.6, gain=1e6)
    assert np.isfinite(found).all()
    assert 0.5 < np.abs(found).max() <= 0.8901


def test_fields_beside_each_other_are_felt_where_they_lie(quiet):
    """From the left field (ridges) to the right one (tile's noise); the border glides."""
    stroke = a_stroke(50.0, 2.0)
    fields = {"fields": [[1, 0], [0, 1]], "width_mm": 50.0, "tap_gain": 0}
    both = rendered(quiet, [FILE, TILE], stroke, 2.0, gain=1e-2, **fields)
    left = rendered(quiet, [FILE], stroke, 2.0, gain=1e-2, tap_gain=0)
    assert np.array_equal(both[: int(0.9 * RATE)], left[: int(0.9 * RATE)])
    assert peak_hz(both[: int(0.9 * RATE)]) == pytest.approx(25, abs=2)
    assert np.corrcoef(both[-38_400:], left[-38_400:])[0, 1] < 0.2


def test_every_coalesced_sample_is_sent(touch):
    """A browser hands several samples of a quick pointer over in one event."""
    sent = touch.evaluate(
        """() => {
          const pad = document.getElementById('touch-pad');
          const box = pad.getBoundingClientRect();
          const kind = 'onpointerrawupdate' in pad ? 'pointerrawupdate' : 'pointermove';
          const at = (n) => ({clientX: box.left + 50 + n, clientY: box.top + 60, pointerType: 'mouse', pointerId: 1});
          const coalescedEvents = [...Array(8).keys()].map((n) => new PointerEvent(kind, at(n)));
          const before = window.tactogramTouch.pad.track.length;
          pad.dispatchEvent(new PointerEvent(kind, {...at(7), coalescedEvents}));
          return window.tactogramTouch.pad.track.slice(before).map(({x}) => x);
        }"""
    )
    assert np.allclose(np.diff(sent), 25.4 / 96)
    assert len(sent) == 8


def test_a_pens_pressure_is_its_force(touch):
    force = touch.evaluate(
        """() => {
          const pad = document.getElementById('touch-pad');
          const box = pad.getBoundingClientRect();
          const at = {clientX: box.left + 50, clientY: box.top + 60, pointerType: 'pen', pointerId: 7, pressure: 0.25};
          pad.dispatchEvent(new PointerEvent('pointerdown', {...at, button: 0, bubbles: true}));
          const {track} = window.tactogramTouch.pad;
          pad.dispatchEvent(new PointerEvent('pointerup', {...at, bubbles: true}));
          return track.slice(-2).map((sample) => sample.force);
        }"""
    )
    assert force == [0.5, 0]


def test_a_phone_is_told_on_and_off_as_the_display_does(quiet):
    """The script's error diffusion and that of the display phone-on-off, on the same strengths."""
    model = AutoregressiveModel.from_coefficients(
        [[1, -1.6, 0.9]], [0.02], rate=1000.0, unit="m/s^2", axes=("z",)
    )
    signal = synthesise(model, 3.0, seed=0)
    phone, level = open_display("phone-on-off"), parse_level("peak=1")
    share = strength(signal, phone.settings, display=phone, level=level).share
    drive, _ = pattern.drive(signal, phone.settings, display=phone, level=level)
    found = quiet.evaluate(
        """async (share) => {
          const {OnOff} = await import('/static/touch_vibration.js');
          const diffusing = new OnOff(2);
          return share.map((value) => diffusing.next(value));
        }""",
        share.tolist(),
    )
    assert found == drive.samples[0].tolist()
    assert 0.2 < np.mean(found) < 0.8


def test_patterns_are_those_that_vibrate_takes(quiet):
    found = quiet.evaluate(
        """async () => {
          const {patternOf} = await import('/static/touch_vibration.js');
          return [[1, 1, 0, 0, 1], [0, 0, 1, 1, 0], [0, 0], []].map((values) => patternOf(values, 20));
        }"""
    )
    assert found == [[40, 40, 20], [0, 40, 40], [], []]


def test_a_stroke_vibrates_and_a_rest_does_not(touch):
    touch.check("#touch-vibrate")
    touch.click("#touch-hand")
    touch.wait_for_function("window.buzzed.filter(Array.isArray).length > 3")
    touch.click("#touch-hand")
    touch.wait_for_function("window.buzzed.at(-1) === 0")
    patterns = [told for told in touch.evaluate("window.buzzed") if isinstance(told, list)]
    assert all(len(told) % 2 == 1 and sum(told) <= 200 for told in patterns)
    assert all(ms % 20 == 0 for told in patterns for ms in told)
    assert any(sum(told[::2]) >= 40 for told in patterns)


def test_a_finger_on_a_touch_screen_strokes_and_lifts(browser, server):
    context = browser.new_context(base_url=server, viewport={"width": 820, "height": 1180}, has_touch=True)
    page = context.new_page()
    page.goto(f"/touch?where=file&of={RIDGES}")
    page.wait_for_selector("#touch[data-ready=true]")
    page.tap("#touch-begin")
    page.wait_for_function("window.tactogramTouch.sound.context.state === 'running'")
    box = page.locator("#touch-pad").bounding_box()
    screen = context.new_cdp_session(page)
    for n in range(40):
        points = [{"x": box["x"] + 100 + 5 * n, "y": box["y"] + 100}]
        kind = "touchMove" if n else "touchStart"
        screen.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    screen.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_function("window.tactogramTouch.pad.track.at(-1).force === 0")
    track = page.evaluate("window.tactogramTouch.pad.track")
    assert track[-1]["x"] - track[0]["x"] == pytest.approx(39 * 5 * 25.4 / 96, abs=0.3)
    assert {s["force"] for s in track[:-1]} == {0.6}
    assert track[-1]["time"] > track[-2]["time"]
    assert page.evaluate("scrollY") == 0
    context.close()


def test_without_a_sound_thread_the_pages_own_makes_the_samples(tab):
    """As browsers have it over plain HTTP beyond this machine."""
    tab.add_init_script(
        "Object.defineProperty(BaseAudioContext.prototype, 'audioWorklet', {value: undefined})"
    )
    tab.goto(f"/touch?where=file&of={RIDGES}")
    tab.wait_for_selector("#touch[data-ready=true]")
    tab.click("#touch-begin")
    tab.click("#touch-hand")
    tab.wait_for_function(
        "window.tactogramTouch.report.state === 'slide' && window.tactogramTouch.report.rms > 0.1"
    )
    tab.get_by_text("Latency", exact=True).click()
    tab.get_by_text("the page's thread").wait_for()


@pytest.mark.parametrize("shown", [0.03, 0.0])
def test_latency_holds_what_the_browser_says_of_its_output(quiet, shown):
    """A block that is made at 2.00 s of the context, 10.00 s of the page, and heard 30 ms later.

    The time stamps hold the delay (Chromium), or are both 30 ms earlier and leave it out (Firefox).
    """
    said = {"heard": 2 - 0.03, "at": 10 - 0.03 + shown, "now": 10, "currentTime": 2, "outputLatency": 0.03}
    left = quiet.evaluate(
        "said => import('/static/touch_sound.js').then(({leaves}) => leaves(2, said))", said
    )
    assert left == pytest.approx(10.03)


@pytest.mark.parametrize(("device", "played"), [(48_000, 48_000), (44_100, 44_100), (24_000, 48_000)])
def test_sound_is_made_at_the_devices_rate_unless_blocks_would_be_too_long(quiet, device, played):
    found = quiet.evaluate(
        """async (device) => {
          const { contextOf } = await import('/static/touch_sound.js');
          const own = AudioContext;
          globalThis.AudioContext = class {
            constructor({ sampleRate = device }) { this.sampleRate = sampleRate; }
            close() {}
          };
          const { sampleRate } = contextOf();
          globalThis.AudioContext = own;
          return sampleRate;
        }""",
        device,
    )
    assert found == played


def test_where_no_sound_begins_it_is_said(touch):
    """As in Firefox on a machine without a sound output: the context never runs."""
    touch.evaluate("""() => {
      const context = window.tactogramTouch.sound.context;
      context.resume = () => new Promise(() => {});
      context.suspend();
      document.getElementById("touch-mute").click();
      document.getElementById("touch-mute").click();
      const now = performance.now.bind(performance);
      performance.now = () => now() + 3100;
    }""")
    touch.get_by_text("The browser has not started the sound").wait_for()


def test_keys_stroke_the_surface(touch):
    touch.focus("#touch-pad")
    touch.keyboard.down("ArrowRight")
    touch.wait_for_function("window.tactogramTouch.pad.track.length > 20")
    touch.keyboard.up("ArrowRight")
    touch.wait_for_function("window.tactogramTouch.pad.track.at(-1).force === 0")
    track = touch.evaluate("window.tactogramTouch.pad.track")
    moved = [s for s in track[:20] if s["force"] > 0]
    speed = (moved[-1]["x"] - moved[0]["x"]) / (moved[-1]["time"] - moved[0]["time"])
    assert speed == pytest.approx(80, rel=0.01)
    assert {s["y"] for s in track} == {track[0]["y"]}


def test_the_page_says_level_scale_and_latency(touch):
    assert "of the loudest possible output, its largest sample at 10 %" in touch.inner_text("#touch-gain")
    assert "peak=0.1" in touch.inner_text("#touch-gain")
    assert "assumed: 3.78 pixels" in touch.inner_text("#touch-scale")
    assert touch.get_attribute("#touch-pad", "aria-label") == (
        f"Surface. {RIDGES}: drawn from the signal, no photograph."
    )
    touch.click("#touch-begin")
    touch.click("#touch-hand")
    touch.wait_for_function("Number.parseFloat(document.getElementById('touch-speed').value) > 20")
    touch.click("#touch-hand")
    box = touch.locator("#touch-pad").bounding_box()
    for n in range(60):
        touch.mouse.move(box["x"] + 50 + 5 * n, box["y"] + 80)
    touch.wait_for_function("/^[0-9]+ ms$/.test(document.getElementById('touch-latency').value)")


def test_choice_volume_and_arrangement_outlive_a_reload(touch):
    touch.goto("/touch")
    touch.wait_for_selector("#touch[data-ready=true]")
    touch.click("#touch-add")
    touch.wait_for_selector("#touch-texture-1")
    touch.select_option("#touch-texture-1", label="cork-sheet")
    touch.wait_for_function("window.tactogramTouch.rows.tables()[1]?.head.name === 'cork-sheet'")
    touch.check("input[value=mixed]")
    touch.fill("#touch-volume", "-30")
    kept = touch.inner_text("#touch-gain")
    touch.reload()
    touch.wait_for_selector("#touch[data-ready=true]")
    assert touch.eval_on_selector("#touch-texture-1", "it => it.selectedOptions[0].text") == "cork-sheet"
    assert touch.is_checked("input[value=mixed]")
    assert touch.inner_text("#touch-gain") == kept
    assert touch.input_value("#touch-volume") == "-30"


def test_a_reload_keeps_what_was_chosen_after_an_address_and_each_tab_its_own(touch):
    touch.goto("/touch?where=run&of=studio/first/voices&material=tile")
    touch.wait_for_selector("#touch[data-ready=true]")
    selected = "it => it.selectedOptions[0].text"
    assert touch.eval_on_selector("#touch-texture-0", selected) == "tile"
    touch.select_option("#touch-texture-0", label="cloth")
    touch.wait_for_function("window.tactogramTouch.rows.tables()[0]?.head.name === 'cloth'")
    other = touch.context.new_page()
    other.goto("/touch?where=run&of=studio/first/voices&material=carpet")
    other.wait_for_selector("#touch[data-ready=true]")
    touch.reload()
    touch.wait_for_selector("#touch[data-ready=true]")
    assert touch.eval_on_selector("#touch-texture-0", selected) == "cloth"
    other.close()


def test_what_was_chosen_last_is_felt_although_what_was_chosen_before_came_later(touch):
    held = []

    def hold(route):
        held.append(route)

    touch.route(re.compile("/touch/table.*material=tile"), hold)
    touch.select_option("#touch-texture-0", label="tile")
    touch.locator("#touch-rows").get_by_text("Loading").wait_for()  # not an empty pad without a word
    touch.select_option("#touch-texture-0", label="cloth")
    touch.wait_for_function("() => window.tactogramTouch.rows.words().includes('cloth')")
    (route,) = held
    with touch.expect_response(re.compile("/touch/picture.*material=tile")):
        route.continue_()
    touch.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")

    assert "cloth" in touch.get_attribute("#touch-pad", "aria-label")
    assert [table["head"]["name"] for table in touch.evaluate(TABLES)] == ["cloth"]


def test_what_cannot_be_felt_is_said_in_its_row(tab):
    tab.goto("/touch?where=file&of=recordings/gone.wav")
    tab.wait_for_selector(".touch-error")
    assert tab.inner_text(".touch-error") == "recordings/gone.wav: no such file in the workspace"
    tab.wrong.clear()  # the browser notes the refused requests


def test_a_texture_is_saved_for_other_pages_and_engines(touch):
    with touch.expect_download() as download:
        touch.get_by_role("link", name="ridges.json").click()
    assert download.value.suggested_filename == "ridges.json"
    document = json.loads(download.value.path().read_text(encoding="utf-8"))
    assert (document["format"], document["version"], document["rate"]) == ("tactogram-texture", 1, 48_000)
    assert (document["kind"], document["unit"], document["picture"]["kind"]) == ("surface", "m/s^2", "drawn")
    with touch.expect_download() as download:
        touch.get_by_role("link", name="tactogram.js").click()
    assert download.value.path().read_text(encoding="utf-8") == element_script()
    touch.get_by_role("link", name="Convert to a haptic file").click()
    touch.get_by_role("tab", name="To a haptic file", selected=True).wait_for()
    touch.get_by_role("heading", name=RIDGES).wait_for()


def test_a_photograph_is_shown_and_felt_where_it_is_stroked(touch, workspace, tmp_path):
    """Bright from 60 mm of 100 mm on, in its middle: the mouse feels the edge there, and nothing on either side."""
    pixels = np.full((300, 600, 3), 50, np.uint8)
    pixels[100:200, 360:] = 200
    write_image(tmp_path / "edge.png", Image(pixels))
    touch.get_by_text("Feel a photograph").click()
    touch.locator("input[type=file][accept*='.jpg']").set_input_files(tmp_path / "edge.png")
    touch.get_by_text("edge.png, drawn: kept and selected.").wait_for()
    touch.get_by_text("The pad shows 100 by 50 mm of the photograph; speeds are those on it.").wait_for()
    touch.get_by_text("Drawn from the brightness along the marked line").wait_for()
    touch.click("#touch-begin")
    touch.wait_for_function("window.tactogramTouch.sound.context.state === 'running'")
    box = touch.locator("#touch-pad").bounding_box()
    assert box["width"] / box["height"] == pytest.approx(2, rel=0.02)
    touch.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.2 * box["height"])
    touch.wait_for_function("window.tactogramTouch.pad.track.at(-1)?.force > 0")
    assert touch.evaluate("window.tactogramTouch.pad.track.at(-1).x") == pytest.approx(30, abs=0.5)
    touch.locator("#touch-pad").screenshot(path=tmp_path / "pad.png")
    shown = np.asarray(Pillow.open(tmp_path / "pad.png").convert("RGB")).astype(int)
    rows, columns = shown.shape[:2]
    for x, y, grey in ((0.5, 0.42, 50), (0.7, 0.42, 200), (0.7, 0.1, 50)):
        assert shown[int(y * rows), int(x * columns)] == pytest.approx([grey] * 3, abs=8), (x, y)
    assert shown[rows // 2, columns // 2] == pytest.approx([11, 93, 102], abs=20)  # the line

    kept = max((workspace / "studio" / "kept").iterdir())
    query = {"where": "kept", "of": kept.name}
    stroke = a_stroke(100.0, 1.0)
    found = rendered(touch, [query], stroke, 1.0, gain=1e-2, tap_gain=0) / 1e-2
    at_mm = np.arange(len(found)) / RATE * 100
    assert at_mm[np.argmax(np.abs(found))] == pytest.approx(60, abs=1.5)
    assert np.abs(found[(at_mm > 5) & (at_mm < 40)]).max() < 0.05 * np.abs(found).max()
    touch.get_by_role("link", name="Convert to a haptic file").click()
    touch.get_by_role("heading", name="edge.png, drawn").wait_for()


def test_a_dropped_recording_is_kept_and_felt(touch, workspace, tmp_path):
    wave = Signal(np.sin(np.arange(4000) / 3)[None].astype(np.float32), 2000.0, "m/s^2")
    write_signal(tmp_path / "mine.wav", wave)
    touch.get_by_text("Feel a recording of your own").click()
    touch.get_by_text("Clone it, for any speed and force").click()
    touch.set_input_files("input[type=file]", tmp_path / "mine.wav")
    touch.get_by_text("Its recording speed is unknown: 100 mm/s is assumed.").wait_for()
    assert touch.evaluate("window.tactogramTouch.rows.tables()[0].head.name") == "mine"
    assert (workspace / "uploads" / "mine.wav").is_file()


def test_a_dropped_recording_is_cloned_for_any_speed(touch, workspace, tmp_path):
    noise = np.random.default_rng(0).standard_normal((1, 4000)).astype(np.float32)
    write_signal(tmp_path / "stroke.wav", Signal(noise, 2000.0, "m/s^2"))
    touch.get_by_text("Feel a recording of your own").click()
    touch.set_input_files("input[type=file]", tmp_path / "stroke.wav")
    touch.get_by_text("stroke is cloned and selected").wait_for()
    touch.wait_for_function("window.tactogramTouch.rows.tables()[0]?.head.name == 'stroke'")
    assert load_run(workspace / "clones" / "stroke.wav").facts.name == "texture_var"


def test_an_everyday_material_is_felt_by_its_name(touch, workspace):
    (workspace / "clones" / "corduroy-strokes").mkdir(parents=True)  # of an attempt that was interrupted
    touch.get_by_text("Feel an everyday material").click()
    field = touch.get_by_label("One of 84 materials")
    field.fill("cordu")
    touch.get_by_role("option", name="corduroy").click()
    touch.get_by_text("corduroy is selected").wait_for()
    touch.wait_for_function("window.tactogramTouch.rows.tables()[0]?.head.name == 'corduroy'")
    assert load_run(workspace / "clones" / "corduroy").kind.materials == ("corduroy",)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"where": "net"}, "where: must be 'run', 'kept' or 'file', got 'net'"),
        ({"lay": "spiral"}, "lay: must be 'auto', .*got 'spiral'"),
        ({"rate": "10"}, "rate: must be greater than or equal to 8000, got '10'"),
        ({"speed": "nan"}, "speed_mm_s: must be .*got 'nan'"),
        ({"seed": "-1"}, "seed: must be greater than or equal to 0, got '-1'"),
        ({"of": ""}, "of: "),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_read(values, words):
    with pytest.raises(ParameterError, match=words):
        parse_request({"where": "run", "of": "x", **values})
