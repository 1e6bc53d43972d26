import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.training.train import train
from tactogram_studio.touch.sources import TextureRequest, texture_choices

VOICES = "studio/first/voices"


def ridges(per_mm=0.5, length_mm=80.0, rate=20.0, amplitude=2.0):
    place = np.arange(round(length_mm * rate)) / rate
    wave = amplitude * np.sin(2 * np.pi * per_mm * place)
    return Signal(wave[None].astype(np.float32), rate, "m/s^2", ("z",), domain="displacement")


def test_materials_kept_signals_and_files_are_offered(studio):
    offers = texture_choices(studio.workspace, studio.shelf)
    assert [offer.title for offer in offers if offer.where == "run"][:3] == [
        "artificial-grass",
        "carpet",
        "cloth",
    ]
    assert all(offer.simulated for offer in offers if offer.where == "run")
    assert [offer.title for offer in offers if offer.where == "kept"] == ["Kept ridges"]
    assert [o.of for o in offers if o.where == "file"] == ["recordings/ridges.npz", "recordings/stroke.wav"]


def test_models_of_one_speed_are_laid_along_the_way_unless_asked_otherwise(sources):
    laid = sources.table(TextureRequest(where="run", of=VOICES, material="tile"))
    assert (laid.head["kind"], laid.head["along"], laid.head["recorded_mm_s"]) == ("surface", "path", 100.0)
    tabled = sources.table(TextureRequest(where="run", of=VOICES, material="tile", lay="table"))
    assert tabled.head["kind"] == "autoregressive"
    assert laid.head["level"] == pytest.approx(tabled.head["level"], rel=0.15)
    assert laid.head["simulated"]
    assert tabled.head["simulated"]


def test_a_speed_that_was_not_recorded_is_limited_and_said(sources, studio):
    tabled = sources.table(TextureRequest(where="run", of=VOICES, material="tile", lay="table"))
    assert tabled.head["notes"][0] == "recorded at 100 mm/s; a stroke of any other speed counts as that"
    fast = sources.table(
        TextureRequest(where="run", of=VOICES, material="tile", speed_mm_s=900.0, lay="path")
    )
    limit = "speed 900 mm/s is outside of what was recorded of tile: it counts as 100 mm/s"
    assert limit in fast.head["notes"]
    assert (
        limit
        not in sources.table(TextureRequest(where="run", of=VOICES, material="tile", lay="path")).head[
            "notes"
        ]
    )
    kept = studio.shelf.keep(ridges(), title="Fast", facts={"limited": [limit]})
    assert sources.table(TextureRequest(where="kept", of=kept.id)).head["notes"] == [limit]
    studio.shelf.remove(kept.id)


def test_a_run_of_texture_var_is_offered_laid_and_tabled(sources, workspace):
    run = train(
        "texture_var",
        workspace / "studio" / "first" / "surfaces",
        recipe="tiny",
        changes={"prepare.rate": 1000},
        where={"material": "tile"},
        split="all",
        out=workspace / "runs" / "var",
    ).folder.relative_to(workspace)
    tabled = sources.table(TextureRequest(where="run", of=str(run), material="tile", lay="table"))
    laid = sources.table(TextureRequest(where="run", of=str(run), material="tile"))
    assert (tabled.head["kind"], laid.head["kind"]) == ("noise", "surface")
    assert laid.head["level"] == pytest.approx(tabled.head["level"], rel=0.25)
    signal, speed = sources.signal(TextureRequest(where="run", of=str(run), material="tile"))
    assert (signal.seconds, speed, signal.axes) == (6.0, 100.0, ("dft321",))
    assert signal.samples.std() == pytest.approx(laid.head["level"], rel=0.1)


def test_a_table_is_made_once_and_anew_when_its_file_changes(sources, workspace):
    asked = TextureRequest(where="file", of="recordings/stroke.wav")
    first = sources.table(asked)
    assert sources.table(asked) is first
    louder = Signal(3 * np.sin(np.arange(6000) / 4)[None].astype(np.float32), 2000.0, "m/s^2")
    write_signal(workspace / "recordings" / "stroke.wav", louder, metadata={"speed_mm_s": 40})
    again = sources.table(asked)
    assert again.head["level"] == pytest.approx(3 * first.head["level"], rel=0.01)
    assert (first.head["recorded_mm_s"], again.head["recorded_mm_s"]) == (80.0, 40.0)
    assert (first.head["simulated"], again.head["simulated"]) == (True, False)


def test_a_kept_result_is_felt_as_it_was_kept(sources, studio):
    made = next(made for made in studio.shelf.all() if not made.is_image)
    table = sources.table(TextureRequest(where="kept", of=made.id, lay="x"))
    assert (table.head["name"], table.head["along"], table.head["simulated"]) == ("Kept ridges", "x", True)


@pytest.mark.parametrize(
    ("asked", "error", "words"),
    [
        (("file", "../outside.wav"), ParameterError, "lies outside of the workspace"),
        (("file", "/etc/passwd"), ParameterError, "lies outside of the workspace"),
        (("file", "recordings/none.wav"), DataError, "no such file"),
        (("file", "studio/first/voices/recipe.toml"), ParameterError, "expected a file of .wav"),
        (("run", "recordings", "tile"), TactogramError, "recordings"),
        (("run", VOICES, "velvet"), ParameterError, "has no material 'velvet'; it has artificial-grass"),
        (("kept", "../../etc"), DataError, "no kept result"),
    ],
)
def test_what_is_not_there_is_refused_with_a_sentence(sources, asked, error, words):
    with pytest.raises(error, match=words):
        sources.table(TextureRequest(**dict(zip(("where", "of", "material"), asked, strict=False))))
