"""The benchmark of workers, at a size that takes a moment."""

from benchmarks import bench_workers


def test_speed_is_reported_beside_that_of_a_plain_loop(monkeypatch):
    for name, value in {"COUNTS": (1,), "STROKES": 2, "IDLE": 3, "ROUNDS": 1}.items():
        monkeypatch.setattr(bench_workers, name, value)
    monkeypatch.setattr(bench_workers, "measured", lambda on, count, todo: (7.0, 0.5 + count, 0.001))
    rows = bench_workers.run()
    assert [(row["on"], row["workers"]) for row in rows] == [("this process", 1), ("ray", 1)]
    assert rows[0]["start-up, s"] == 1.5
    assert rows[0]["overhead per task, ms"] == 1.0


def test_times_are_those_of_the_first_and_the_last_outcome():
    def outcomes():
        yield 1
        sum(range(10**6))
        yield 2

    first, last = bench_workers.times(outcomes())
    assert 0 <= first < last
