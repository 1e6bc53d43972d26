"""Texts in attributes, and charts."""

from tactogram_studio.kit import line_chart


def test_only_positive_values_are_shown_on_a_logarithmic_scale():
    assert line_chart({"a": [(1, 1.0)]}, x="step", log_scale=True)["yAxis"]["type"] == "log"
    assert line_chart({"a": [(1, -1.0)]}, x="step", log_scale=True)["yAxis"]["type"] == "value"
