"""`<tactogram-pad>` in a plain page, served by a static server: no studio, no network, a strict policy for scripts."""

import functools
import http.server
import json
import re
import threading
from pathlib import Path

import pytest
from PIL import Image as Pillow

from tactogram_studio.touch.document import texture_document
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.sources import TextureRequest

ROOT = Path(__file__).parents[4]
STATIC = "/packages/tactogram-studio/src/tactogram_studio/static"
FILE = {"where": "file", "of": "recordings/ridges.npz"}
TILE = {"where": "run", "of": "studio/first/voices", "material": "tile", "lay": "table"}
PAD = "document.querySelector('tactogram-pad')"
SAME = """async ({packed, text, base}) => {
  const {readTable} = await import(`${base}/touch_textures.js`);
  const {readDocument} = await import(`${base}/touch_document.js`);
  const one = readTable(Uint8Array.from(packed).buffer);
  const other = readDocument(text).table;
  const bits = (array) => [array.constructor.name, ...new Uint8Array(array.slice().buffer)].join();
  const names = Object.keys(one.arrays);
  const heads = [one.head, other.head].map(({arrays, version, ...facts}) => JSON.stringify(facts));
  return heads[0] === heads[1] && names.join() === Object.keys(other.arrays).join()
    && names.every((name) => bits(one.arrays[name]) === bits(other.arrays[name]));
}"""
RENDERED = """async ({text, base, worklet}) => {
  const {readDocument} = await import(`${base}/touch_document.js`);
  const {head, buffer} = readDocument(text).table;
  const context = new OfflineAudioContext(1, 24000, 48000);
  await context.audioWorklet.addModule(worklet);
  const samples = [...Array(100).keys()].map((n) => ({time: n / 200, x: n, y: 0, force: 0.6}));
  const messages = [
    {kind: 'textures', tables: [{head, buffer}], seed: 5, fields: [[1]]},
    {kind: 'output', gain: 0.01, open: true, settled: true},
    {kind: 'script', samples},
  ];
  const options = {numberOfInputs: 0, outputChannelCount: [1], processorOptions: {messages}};
  new AudioWorkletNode(context, 'tactogram-touch', options).connect(context.destination);
  return [...(await context.startRendering()).getChannelData(0)];
}"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass

    def do_GET(self):
        if self.path == "/favicon.ico":  # which browsers ask for
            self.send_response(204)
            self.end_headers()
        elif self.path == "/bundled.js":  # with what does not run in an audio thread
            content = b"document.title;\n" + (ROOT / "packages/tactogram-js/tactogram.js").read_bytes()
            self.send_response(200)
            self.send_header("Content-Type", "text/javascript")
            self.end_headers()
            self.wfile.write(content)
        else:
            super().do_GET()


@pytest.fixture(scope="module")
def address():
    """Give the address of the project's root, on a static server."""
    handler = functools.partial(Quiet, directory=ROOT)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture
def page(browser, address):
    """Give a page that fails on its errors, and on requests to other hosts."""
    context = browser.new_context(base_url=address, viewport={"width": 900, "height": 600})
    tab = context.new_page()
    tab.wrong = []
    tab.on("pageerror", lambda error: tab.wrong.append(str(error)))
    tab.on("console", lambda entry: tab.wrong.append(entry.text) if entry.type == "error" else None)
    tab.on("request", lambda made: None if made.url.startswith(address) else tab.wrong.append(made.url))
    yield tab
    context.close()
    assert tab.wrong == []


@pytest.fixture
def corduroy(page):
    page.goto("/examples/web/")
    page.get_by_role("application", name="Surface of corduroy").wait_for()
    return page


def stroked(page, x):
    """Move the mouse over the pad by 240 px from ``x``."""
    box = page.get_by_role("application").bounding_box()
    for n in range(60):
        page.mouse.move(box["x"] + x + 4 * n, box["y"] + 90)


def test_a_stroke_by_mouse_sounds(corduroy, tmp_path):
    corduroy.get_by_text("Simulated; follows speed and force.").wait_for()
    assert corduroy.evaluate(f"{PAD}.report.rms") == 0
    corduroy.get_by_role("button", name="Press to start").click()
    corduroy.wait_for_function(f"() => {PAD}.report.time > 0")
    corduroy.evaluate(
        f"() => {{ window.strongest = 0; setInterval(() => {{ const {{rms, state}} = {PAD}.report;"
        " if (state === 'slide') window.strongest = Math.max(window.strongest, rms); }, 5); }"
    )
    stroked(corduroy, 30)
    corduroy.wait_for_function("() => window.strongest > 0.1")
    assert corduroy.evaluate(f"{PAD}._sound.threaded")
    assert corduroy.evaluate(f"{PAD}._sound.context.sampleRate") == 48_000
    corduroy.get_by_role("button", name="Turn the sound off").click()
    corduroy.get_by_role("button", name="Turn the sound on").wait_for()
    corduroy.get_by_role("application").screenshot(path=tmp_path / "pad.png")
    colours = Pillow.open(tmp_path / "pad.png").convert("L").getextrema()
    assert colours[1] - colours[0] > 60  # a surface, not an empty field


def test_it_is_used_by_keyboard(corduroy, faults):
    assert faults(corduroy) == []
    corduroy.get_by_role("button", name="Press to start").focus()
    corduroy.keyboard.press("Enter")
    corduroy.wait_for_function(f"() => {PAD}.shadowRoot.activeElement.role === 'application'")
    corduroy.keyboard.down("ArrowRight")
    corduroy.wait_for_function(f"() => {PAD}.report.state === 'slide' && {PAD}.report.rms > 0.05")
    corduroy.keyboard.up("ArrowRight")
    corduroy.wait_for_function(f"() => {PAD}.report.state === 'air'")


def test_its_attributes_may_change(corduroy):
    assert corduroy.evaluate(f"() => {PAD}.gain") == pytest.approx(0.1 / 4.030437469482422)
    corduroy.evaluate(
        f"() => {{ {PAD}.setAttribute('gain', '0.05'); {PAD}.setAttribute('label', 'Trousers'); }}"
    )
    corduroy.get_by_role("application", name="Trousers").wait_for()
    assert corduroy.evaluate(f"() => {PAD}.gain") == 0.05
    corduroy.evaluate(f"() => {PAD}.remove()")  # without errors, nor sound
    assert corduroy.get_by_role("application").count() == 0


@pytest.mark.parametrize(
    ("src", "message"),
    [
        ("none.json", "none.json: cannot be loaded: 404 File not found"),
        (
            "index.html",
            "index.html: expected a tactogram-texture, got no JSON; write one with: tactogram touch",
        ),
        (
            "/packages/tactogram-js/package.json",
            "/packages/tactogram-js/package.json: expected a tactogram-texture, version 1, got another JSON; "
            "write one with: tactogram touch",
        ),
    ],
)
def test_what_is_no_texture_is_said_in_a_line(corduroy, src, message):
    corduroy.evaluate(f"(src) => {{ {PAD}.src = src; }}", src)
    assert corduroy.get_by_role("alert").inner_text() == message
    assert corduroy.get_by_role("application").count() == 0
    corduroy.wrong[:] = [text for text in corduroy.wrong if "404" not in text]  # the browser notes it, too


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"version": 2, "arrays": {}}, "version 1, got version 2;"),
        ({"version": 1}, "other.json: its arrays are damaged; write it again with: tactogram touch"),
        ({"version": 1, "arrays": {"speeds": {"type": "text", "values": ["a"]}}}, "its arrays are damaged"),
    ],
)
def test_another_version_and_a_damaged_file_are_refused(corduroy, document, message):
    text = json.dumps({"format": "tactogram-texture", **document})
    corduroy.route("**/other.json", lambda route: route.fulfill(body=text))
    corduroy.evaluate(f"() => {{ {PAD}.src = 'other.json'; }}")
    corduroy.get_by_role("alert").get_by_text(re.compile(message)).wait_for()


def test_bundled_into_a_script_of_a_page_it_sounds_without_a_sound_thread(page):
    text = (ROOT / "examples/web/index.html").read_text(encoding="utf-8")
    text = re.sub('src="[^"]*tactogram.js"', 'src="/bundled.js"', text)
    page.route("**/examples/web/", lambda route: route.fulfill(body=text, content_type="text/html"))
    page.goto("/examples/web/")
    page.get_by_role("button", name="Press to start").click()
    page.get_by_role("application").focus()
    page.keyboard.down("ArrowRight")
    page.wait_for_function(f"() => {PAD}.report.state === 'slide' && {PAD}.report.rms > 0.05")
    assert not page.evaluate(f"{PAD}._sound.threaded")


@pytest.mark.parametrize("query", [FILE, TILE], ids=["surface", "models"])
def test_a_document_holds_the_bits_that_the_studio_plays(page, sources, query):
    request = TextureRequest(**query)
    table = sources.table(request)
    text = texture_document(table, picture_of(sources, request))
    page.goto("/packages/tactogram-js/package.json")
    values = {"packed": list(table.packed()), "text": text, "base": STATIC}
    assert page.evaluate(SAME, values)


def test_its_sound_thread_makes_the_samples_of_the_studios(page):
    page.goto("/packages/tactogram-js/package.json")
    text = (ROOT / "examples/web/corduroy.json").read_text(encoding="utf-8")
    worklets = (f"{STATIC}/touch_worklet.js", "/packages/tactogram-js/tactogram.js")
    studio, own = (
        page.evaluate(RENDERED, {"text": text, "base": STATIC, "worklet": worklet}) for worklet in worklets
    )
    assert max(studio) > 1e-3
    assert own == studio
