"""A photographer: from a photograph of ridges to their touch under the finger, and a file for a phone."""

import json

import numpy as np
from PIL import Image

RIDGES = 25
"""In 100 mm of the photograph: 4 mm each, 25 Hz under a finger at 100 mm/s."""


def test_a_photograph_is_felt_and_becomes_a_file_for_a_phone(page, saved, step, tmp_path):
    ridges = 128 + 90 * np.sin(2 * np.pi * RIDGES * np.arange(1000) / 1000)
    pixels = np.broadcast_to(ridges[None, :, None], (500, 1000, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "ridges.jpg", quality=90)
    with step("the photograph on the first page"):
        page.goto("/")
        page.locator("input[type=file][accept='image/*']").set_input_files(tmp_path / "ridges.jpg")
    with step("under the finger"):
        page.get_by_role("application", name="Surface. Photograph ridges.jpg, drawn.").wait_for()
        page.get_by_text("The pad shows 100 by 50 mm of the photograph").wait_for()
    with step("to a file"):
        page.get_by_role("link", name="Convert to a haptic file").click()
        page.get_by_role("heading", name="ridges.jpg, drawn").wait_for()
        page.get_by_role("button", name="Write and check").click()
        files = page.get_by_role("region", name="Files")
        files.get_by_role("table").wait_for()
        file = saved(files.get_by_role("link", name=".ahap"))
    pattern = json.loads(file.read_text())["Pattern"]
    kinds = {entry["Event"]["EventType"] for entry in pattern if "Event" in entry}
    assert kinds <= {"HapticContinuous", "HapticTransient"}
    ends = [
        entry["Event"]["Time"] + entry["Event"].get("EventDuration", 0)
        for entry in pattern
        if "Event" in entry
    ]
    assert 0.8 < max(ends) < 1.2  # 100 mm at 100 mm/s
