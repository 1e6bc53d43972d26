"""The preview of an import as text."""

from tactogram.cli.import_preview import preview_text, several_rates

COLUMNS = [
    {"heading": "t", "role": "time", "unit": "s"},
    {"heading": "x", "role": "x", "unit": "g"},
    {"heading": "surface", "role": "material", "unit": None},
]
LAYOUT = {
    "files": 2,
    "skipped": 1,
    "mapped": False,
    "example": "cork/1.csv",
    "columns": COLUMNS,
    "streams": {"acceleration": {"axes": ["x"], "unit": "g"}},
    "seconds": (2.0, 4.0),
    "rates_hz": [500.0],
    "estimated_rates_hz": (499.5, 500.5),
    "jitter_s": 2e-4,
    "interpolated": 3,
    "largest_gap_s": 0.004,
    "materials": {"cork": 3, "felt": 1},
}
FACTS = {
    "layouts": [LAYOUT],
    "files": 2,
    "photographs": 0,
    "duplicates": 1,
    "skipped_files": 1,
    "several_rates_hz": {},
    "proposed_path": "",
    "question": "",
    "unused_layouts": [],
    "mapping": "",
}


def test_a_layout_has_its_columns_streams_timing_and_labels():
    lines = [" ".join(line.split()) for line in preview_text(FACTS, ["cork/2.csv: broken"]).splitlines()]
    assert lines[0] == "layout 1: 2 files, 1 skipped, e.g. cork/1.csv"
    assert lines[1:4] == ["t time s", "x x g", "surface material"]
    assert lines[4] == "acceleration: x in g"
    assert lines[5] == (
        "500 Hz (time stamps: 499.5 to 500.5 Hz, jitter up to 200 us), 2 to 4 s; "
        "3 samples interpolated, longest gap 4 ms"
    )
    assert lines[6] == "column 'surface': labels, 2 materials in 4 recordings"
    assert "cork/2.csv: broken" in lines
    assert "files: 2; photographs: 0; duplicates: 1; would be skipped: 1" in lines
    assert lines[-1].startswith("to read columns otherwise: --save-mapping FILE.toml")


def test_a_mapping_is_named_with_its_option():
    text = preview_text(FACTS | {"mapping": "mine.toml", "unused_layouts": [["a", "b"]]}, [])
    assert "mapping: no file has the columns a, b" in text
    assert text.endswith("mapping: mine.toml; edit it, and use it with --mapping mine.toml")


def test_several_rates_are_listed_with_what_to_do():
    assert several_rates({"acceleration": [500.0, 1000.0]}) == [
        "acceleration: 500, 1000 Hz; a training needs one rate: train … --set prepare.rate=500"
    ]
