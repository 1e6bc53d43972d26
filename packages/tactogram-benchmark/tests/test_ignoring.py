"""Models that ignore the input."""

from tactogram_benchmark import ignoring


def test_what_ignores_the_surface_keeps_speed_and_force():
    fast, slow = {"speed_mm_s": 200.0, "force_n": 1.0}, {"speed_mm_s": 50.0, "force_n": 1.0}
    items = [(fast, "a"), (slow, "b"), (slow, "c"), ({}, "d")]
    assert ignoring._alike(items, {**slow, "image": "photo"}) == ["b", "c"]
    assert ignoring._alike(items, {"force_n": 1.0}) == ["a", "b", "c"]
    assert ignoring._alike(items, {"speed_mm_s": 120.0}) == ["a", "b", "c", "d"]  # none of that speed
