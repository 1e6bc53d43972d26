"""Lines of numbers, in any pieces."""

import math

from hypothesis import given, settings, strategies as st

from tactogram_capture.stream.csv_lines import CsvParser


@settings(max_examples=60)
@given(st.binary(max_size=1500), st.integers(1, 200))
def test_bytes_in_any_pieces_never_crash_and_give_the_same_rows(data, step):
    whole, pieces = CsvParser(), CsvParser()
    expected = whole.feed(data)
    whole.finish()
    found = []
    for start in range(0, len(data), step):
        found += pieces.feed(data[start : start + step])
    pieces.finish()

    def plain(rows):
        return [row if row is None else [None if math.isnan(v) else v for v in row] for row in rows]

    assert plain(found) == plain(expected)
    assert whole.rejected == pieces.rejected
