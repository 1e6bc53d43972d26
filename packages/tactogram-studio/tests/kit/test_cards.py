"""Texts in attributes."""

from tactogram_studio.kit import attribute


def test_an_attribute_keeps_no_quotes_backslashes_or_line_breaks():
    assert attribute('rubber "soft"\nC:\\x') == "rubber 'soft' C:/x"
