"""Results as text."""

from tactogram.cli.printing import shortened


def test_long_lists_of_names_are_told_by_number():
    names = [f"image{n:03d}" for n in range(320)]
    assert shortened(names)[-1] == "… (320 in all)"
    assert len(shortened(names)) == 11
    assert shortened(names[:12]) == names[:12]
    assert shortened(dict.fromkeys(names, 1))["…"] == "(320 in all)"
    assert shortened(dict.fromkeys(names[:40], 1)) == dict.fromkeys(names[:40], 1)
