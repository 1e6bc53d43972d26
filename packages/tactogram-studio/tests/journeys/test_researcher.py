"""A researcher: from tables of a logger to a classifier, a mix, and the drive of an actuator; typed and clicked."""

import shutil

import numpy as np
from scipy.signal import lfilter

from tactogram.datasets import open_store
from tactogram.signal.io import read_signal

MATERIALS = {"cork": 0.9, "felt": 0.3, "tile": -0.6}
HEADING = "Elapsed Time (s);X-Axis (g);Y-Axis (g);Z-Axis (g)"


def log(file, pole, seed):
    """Write what a logger with semicolons, decimal commas and jittered stamps writes."""
    rng = np.random.default_rng(seed)
    times = np.arange(4000) / 1000 + rng.normal(0, 2e-5, 4000)
    g = 0.1 * lfilter([1], [1, -pole], rng.standard_normal((3, 4000)))
    rows = (";".join(f"{value:.6f}" for value in row).replace(".", ",") for row in np.vstack([times, g]).T)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(["Logger 2.1", "", HEADING, *rows]))


def test_own_tables_become_a_classifier_a_mix_and_a_drive(tactogram, tmp_path, step):
    for name, pole in MATERIALS.items():
        for number in range(10):
            log(tmp_path / "lab" / name / f"{number}.csv", pole, seed=len(name) * 100 + number)
    (tmp_path / "lab/felt/broken.csv").write_text(f"{HEADING}\n0,1;a;b;c\n")
    with step("preview"):
        said = tactogram("data import folder lab --preview", status=1)
    assert "broken.csv" in said
    with step("import"):
        tactogram("data import folder lab --out store --skip-bad")
    store = open_store(tmp_path / "store")
    assert len(store) == 30
    assert store[0].stream("acceleration").rate == 1000.0
    with step("train a classifier"):
        tactogram("train stroke_cnn --data store --out runs/names")
    with step("evaluate it"):
        said = tactogram("evaluate runs/names")
    with step("fit a generator, mix, classify the mix"):
        tactogram("train texture_var --data store --out runs/textures")
        tactogram("generate runs/textures --mix cork=0.5,felt=0.5 --seconds 3 --out mix.wav")
        tactogram("classify runs/names mix.wav")
    with step("a drive for a voice coil"):
        tactogram("render mix.wav --display voice-coil --level sensation --out drive.wav")
    drive = read_signal(tmp_path / "drive.wav")
    assert 2.9 < drive.seconds < 3.2
    assert drive.unit == "V"
    assert 0 < np.abs(drive.samples).max() <= 5  # its limit


def test_a_zip_of_own_tables_is_dropped_trained_on_and_classifies_a_new_file(page, step, tmp_path):
    recordings = tmp_path / "strokes"
    for number, subject in enumerate(("anna", "ben", "chloe", "dev", "eva")):
        for name, pole in MATERIALS.items():
            for take in range(2):
                log(
                    recordings / subject / name / f"{take}.csv",
                    pole,
                    seed=1000 * number + 10 * len(name) + take,
                )
    log(tmp_path / "new.csv", MATERIALS["tile"], seed=9)
    archive = shutil.make_archive(str(tmp_path / "strokes"), "zip", tmp_path, "strokes")
    with step("the zip is read"):
        page.goto("/materials/import")
        page.locator("input[type=file][accept='.zip']").set_input_files(archive)
        page.wait_for_url("**/materials/import?**")
        page.get_by_text("both may be the materials").wait_for()
    with step("what its folders mean"):
        page.get_by_role("button", name="{subject}/{material}/{take}").click()
        page.get_by_text(
            "30 recordings of 3 materials would be imported from 30 files; 0 would be"
        ).wait_for()
    with step("import"):
        page.get_by_role("button", name="Import", exact=True).click()
        page.get_by_text("data/strokes is complete").wait_for()
    store = open_store(tmp_path / "studio/data/strokes")
    assert {info.subject for info in store.index} == {"anna", "ben", "chloe", "dev", "eva"}
    assert {info.material for info in store.index} == set(MATERIALS)
    with step("train a classifier, tested on unseen people"):
        page.get_by_role("link", name="Train a model").click()
        page.get_by_label("Purpose").click()
        page.get_by_role("option", name="Recognise materials").click()
        page.get_by_text("Recommended: stroke_statistics").wait_for()
        page.get_by_role("button", name="More options").click()
        page.get_by_label("Keep together").click()
        page.get_by_role("option", name="recordings of a subject").click()
        page.get_by_text("--by subject").wait_for()
        page.get_by_role("button", name="Start").click()
        page.get_by_role("button", name="Classify a file").wait_for(timeout=120_000)
    with step("evaluate it"):
        page.get_by_role("button", name="Evaluate").click()
        page.get_by_role("link", name="Read the report").wait_for(timeout=120_000)
    with step("classify a new file"):
        page.get_by_role("button", name="Classify a file").click()
        page.locator("input[type=file]").set_input_files(tmp_path / "new.csv")
        page.get_by_text("4 s at 1,000 Hz · axes x, y, z").wait_for()
        page.locator("[data-verdict]").wait_for()
    assert page.locator("[data-verdict]").inner_text() == "Classified as tile"
    assert page.locator(".q-select", has_text="classifier runs/").count()
