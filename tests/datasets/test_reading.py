"""What is said of many files, in one line each."""

from tactogram.datasets.reading import by_kind, in_one_line
from tactogram.errors import Message


def test_what_is_said_of_many_files_is_one_line():
    said = [
        (f"cork/{n}.csv", Message(f"expected a number, got 'x{n}'", place=f"/data/cork/{n}.csv: row {n}"))
        for n in range(12)
    ]
    [kind] = by_kind(said)
    assert (kind["count"], kind["files"]) == (12, ["cork/0.csv", "cork/1.csv", "cork/2.csv"])
    assert in_one_line(kind) == (
        "12 files: row 0: expected a number, got 'x0' (cork/0.csv, cork/1.csv, cork/2.csv, …)"
    )
    assert in_one_line(by_kind(said[:1])[0]) == "cork/0.csv: row 0: expected a number, got 'x0'"
