import csv
import json

import pytest

from tactogram_study.session.export import (
    export_bids,
    notes_table,
    participants_table,
    write_companion_tables,
)
from tactogram_study.simulated_participants import simulate


@pytest.fixture
def noted(store):
    simulate(store, 2, most_pages=3)
    first, second = (known.code for known in store.participants())
    store.log_device(first, {"px_per_mm": 6.25, "pointer": "pen"})
    page = store.page(second)
    store.submit(second, page.token, {"which": "A"}, device={"refresh_hz": 60})
    store.note("The display was warm,\nand hummed", code=first)
    store.note("Power went at noon")
    return store


def read(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_participants_and_notes_stand_beside_the_table(noted, tmp_path):
    participants, notes = write_companion_tables(tmp_path / "a.csv", noted)
    assert (participants.name, notes.name) == ("a.participants.csv", "a.notes.csv")
    first, second = read(participants)
    assert (first["device_px_per_mm"], first["device_pointer"], first["simulated"]) == ("6.25", "pen", "true")
    assert (second["device_px_per_mm"], second["trials"]) == ("", "2")
    assert "device_refresh_hz" not in second
    assert [(row["participant"], row["text"]) for row in read(notes)] == [
        (first["participant"], "The display was warm,\nand hummed"),
        ("", "Power went at noon"),
    ]


def test_an_export_after_a_withdrawal_leaves_no_note_of_who_withdrew(noted, tmp_path):
    write_companion_tables(tmp_path / "a.csv", noted)
    gone = noted.participants()[0].code
    noted.withdraw(gone)
    write_companion_tables(tmp_path / "a.csv", noted)
    assert [row["text"] for row in read(tmp_path / "a.notes.csv")] == ["Power went at noon"]
    assert gone not in (tmp_path / "a.participants.csv").read_text()


def test_a_bids_folder_holds_notes_and_devices_and_is_valid(noted, tmp_path, bids_issues):
    folder = export_bids(noted, tmp_path / "bids")
    assert bids_issues(folder) == []
    lines = (folder / "sourcedata" / "notes.tsv").read_text().splitlines()
    assert len(lines) == 3
    assert lines[2].startswith("n/a\tPower went at noon\t")
    described = json.loads((folder / "participants.json").read_text())
    assert described["device_px_per_mm"]["Description"].startswith("CSS pixels for each mm")
    sidecars = [json.loads(path.read_text()) for path in folder.glob("sub-*/ses-1/beh/*_beh.json")]
    assert any("device_refresh_hz" in sidecar for sidecar in sidecars)


def test_tables_without_rows_have_their_headings(store):
    assert notes_table(store) == (["participant", "text", "at"], [])
    assert participants_table(store)[1] == []
