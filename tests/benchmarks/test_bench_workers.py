"""The benchmark of workers, at a size that takes a moment."""

from benchmarks import bench_workers


def test_each_engine_is_measured_in_every_round(monkeypatch):
    for name, value in {"COUNTS": (1,), "STROKES": 1, "ROUNDS": 3}.items():
        monkeypatch.setattr(bench_workers, name, value)
    rounds = iter([1.0, 10.0, 5.0, 2.0, 7.0, 6.0])
    monkeypatch.setattr(bench_workers, "measured", lambda on, count, todo: {"speed-up": next(rounds)})
    rows = bench_workers.run()
    assert [(row["on"], row["workers"], row["speed-up"]) for row in rows] == [
        ("this process", 1, 5.0),
        ("ray", 1, 6.0),
    ]


def test_a_measurement_has_every_figure(monkeypatch):
    monkeypatch.setattr(bench_workers, "IDLE", 3)
    todo = bench_workers.tasks("stroking9", seed=0, per_class=1, seconds=1.0, rate=500.0)[:3]
    found = bench_workers.measured("", 1, todo)
    assert found["speed-up"] > 0
    assert found["processor time per stroke"] > 0
    assert found["start-up, s"] >= 0
    assert found["overhead per task, ms"] >= 0
