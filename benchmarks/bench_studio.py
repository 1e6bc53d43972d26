"""Memory of the studio at rest, and what its pages send.

A studio in an empty folder, in Chromium without a cache. "MB": proportional set size of the server and of all processes
that it started, after each step, once they use no more processor time. "kB sent": of all responses of a page in a new
browser, compressed as they were sent, with the websocket's messages.
"""

from __future__ import annotations

import re
import shutil
import tempfile
import time
from pathlib import Path

import psutil
from playwright.sync_api import sync_playwright

from benchmarks.bench_touch import ARGUMENTS, served

MOST_MB, MOST_KB = 600, 700
CHART_KB = 100
"""More for the page Make, whose map loads ECharts."""
PAGES = (
    "/",
    "/make",
    "/touch",
    "/edit",
    "/materials",
    "/materials/import",
    "/train",
    "/send",
    "/live",
    "/studies",
    "/reports",
)
PATIENCE_MS = 120_000


def run():
    return list(steps())


def steps():
    with tempfile.TemporaryDirectory() as folder:
        serving = served(Path(folder))
        with serving as address, sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=list(ARGUMENTS)
            )
            yield row("started, example surfaces made", serving.pid)
            sent = {path: kilobytes_sent(browser, address, path) for path in PAGES}
            yield row("every page opened", serving.pid)
            page = browser.new_page(base_url=address)
            page.set_default_timeout(PATIENCE_MS)
            page.goto("/make")
            page.get_by_role("button", name="Generate", exact=True).click()
            page.locator(".signal canvas").nth(1).wait_for()
            yield row("generated once", serving.pid)
            page.goto("/")
            page.get_by_label("A surface or an effect, in English").fill("a soft furry rug")
            page.get_by_role("button", name="Make it").click()
            page.get_by_role("heading", name=re.compile("rug")).wait_for()
            yield row("words made a texture", serving.pid)
            page.goto("/touch")
            page.get_by_text("Feel an everyday material").click()
            page.get_by_label("One of 84 materials").fill("corduroy")
            page.get_by_role("option", name="corduroy", exact=True).click()
            page.wait_for_function("() => window.tactogramTouch.rows.words().includes('corduroy')")
            yield row("a material cloned", serving.pid)
            browser.close()
        yield from ({"page": path, "kB sent": round(kb)} for path, kb in sent.items())


def row(step, pid):
    wait_until_idle(pid)
    return {"after": step, "MB": round(megabytes(pid))}


def megabytes(pid):
    """Return the proportional set size of a process and of all that it started, MB."""
    process = psutil.Process(pid)
    family = [process, *process.children(recursive=True)]
    return sum(each.memory_full_info().pss for each in family) / 1e6


def wait_until_idle(pid, seconds=2.0, most=180.0):
    """Wait until a process and its children use less than a twentieth of a processor."""
    until, before = time.monotonic() + most, float("inf")
    while time.monotonic() < until:
        process = psutil.Process(pid)
        used = sum(sum(each.cpu_times()[:2]) for each in (process, *process.children(recursive=True)))
        if abs(used - before) < 0.05 * seconds:
            return
        before = used
        time.sleep(seconds)


def kilobytes_sent(browser, address, path):
    """Return what a page sends to a browser without a cache, until all that it shows is there, kB."""
    context = browser.new_context(base_url=address)
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    network, sizes, messages = context.new_cdp_session(page), [], []
    network.send("Network.enable")
    network.on("Network.loadingFinished", lambda told: sizes.append(told["encodedDataLength"]))
    network.on(
        "Network.webSocketFrameReceived", lambda told: messages.append(len(told["response"]["payloadData"]))
    )
    page.goto(path)
    page.get_by_role("heading", level=1).wait_for()
    if path == "/touch":
        page.wait_for_selector("#touch[data-ready=true]")
    if path == "/make":
        page.wait_for_selector(".map-place canvas")
    page.wait_for_timeout(3000)  # the page Live never rests
    context.close()
    return (sum(sizes) + sum(messages)) / 1e3
