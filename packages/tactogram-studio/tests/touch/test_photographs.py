"""Photographs drawn as touch: they are kept, shown, and felt where they show it."""

import io
import json

import numpy as np
import pytest
from PIL import Image as Pillow

from tactogram.errors import DataError, ParameterError
from tactogram_studio.touch.document import texture_document
from tactogram_studio.touch.photographs import keep_drawn
from tactogram_studio.touch.pictures import picture_of
from tactogram_studio.touch.sources import TextureRequest


def file_of(row, *, rows=60, kind="JPEG"):
    """Return a file of grey columns, 0 to 1."""
    grey = np.round(255 * np.asarray(row))[None, :, None]
    with io.BytesIO() as buffer:
        Pillow.fromarray(np.broadcast_to(grey, (rows, len(row), 3)).astype(np.uint8)).save(buffer, kind)
        return buffer.getvalue()


def step(columns=500, at=0.6):
    return np.where(np.arange(columns) < at * columns, 0.2, 0.8)


@pytest.fixture
def drawn(studio):
    """Give a kept photograph that shows 200 mm and is brighter from 120 mm on."""
    kept = keep_drawn(studio.shelf, "edge.jpg", file_of(step()), width_mm=200.0)
    yield kept
    studio.shelf.remove(kept.id)


def test_an_edge_is_felt_where_the_photograph_shows_it(sources, drawn):
    table = sources.table(TextureRequest(where="kept", of=drawn.id))
    head, nodes = table.head, table.arrays["nodes"][: table.arrays["nodes"].size // table.head["copies"]]
    assert (head["along"], head["unit"], head["simulated"]) == ("x", "1", False)
    assert head["length_mm"] == pytest.approx(200.0)
    assert "a design, no prediction of how the material feels" in head["notes"][0]
    assert np.argmax(nodes) / head["nodes_per_mm"] == pytest.approx(120.0, abs=0.5)
    far = np.abs(np.arange(len(nodes)) / head["nodes_per_mm"] - 120) > 30
    assert np.abs(nodes[far]).max() < 0.05 * nodes.max()
    place = np.arange(len(table.arrays["vibration"])) * head["vibration_step_mm"]
    assert place[np.argmax(table.arrays["vibration"])] == pytest.approx(120.0, abs=3)


def test_the_pad_shows_the_photograph_and_its_line(sources, drawn):
    picture = picture_of(sources, TextureRequest(where="kept", of=drawn.id))
    shown = np.asarray(Pillow.open(io.BytesIO(picture.webp)).convert("L"))
    assert (picture.kind, picture.line, shown.shape) == ("photograph", 0.5, (60, 500))
    assert picture.mm_per_pixel == pytest.approx(0.4)
    assert shown[:, :280].mean() == pytest.approx(0.2 * 255, abs=3)
    assert shown[:, 320:].mean() == pytest.approx(0.8 * 255, abs=3)
    assert picture.headers()["X-Line"] == "0.5"
    assert picture.words == "Photograph edge.jpg, drawn"
    request = TextureRequest(where="kept", of=drawn.id)
    document = json.loads(texture_document(sources.table(request), picture))
    assert document["picture"]["line"] == 0.5


def test_along_the_path_it_is_a_signal_like_others(sources, drawn):
    request = TextureRequest(where="kept", of=drawn.id, lay="path")
    assert sources.table(request).head["along"] == "path"
    picture = picture_of(sources, request)
    assert (picture.kind, picture.line) == ("drawn", None)


def test_a_large_photograph_keeps_its_scale(sources, studio):
    kept = keep_drawn(studio.shelf, "wide.png", file_of(step(5000), kind="PNG"), width_mm=100.0)
    picture = picture_of(sources, TextureRequest(where="kept", of=kept.id))
    assert Pillow.open(io.BytesIO(picture.webp)).width * picture.mm_per_pixel == pytest.approx(100.0)
    assert kept.photograph().size == (60, 5000)
    studio.shelf.remove(kept.id)


@pytest.mark.parametrize(
    ("data", "error", "message"),
    [
        (b"no picture", DataError, "a.jpg: not a readable picture"),
        (file_of(np.full(300, 0.5)), ParameterError, "no contrast to draw"),
    ],
)
def test_what_cannot_be_drawn_is_not_kept(studio, data, error, message):
    before = len(studio.shelf.all())
    with pytest.raises(error, match=message):
        keep_drawn(studio.shelf, "a.jpg", data, width_mm=100.0)
    assert len(studio.shelf.all()) == before
