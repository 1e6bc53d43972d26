import numpy as np

from tactogram_studio.pages.make.mix_view import label_sides, map_options

PLACES = np.array([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8], [0.5, 0.45], [0.2, 0.7]])


def test_the_chart_has_each_material_at_its_place():
    chart = map_options("abcde", PLACES)

    dots = chart["series"]["data"]
    assert [dot["name"] for dot in dots] == list("abcde")
    np.testing.assert_array_equal([dot["value"] for dot in dots], PLACES)
    assert [dot["label"]["position"] for dot in dots] == ["right"] * 5


def test_a_name_stays_off_other_dots_off_names_and_on_the_map():
    places = np.array([[0.4, 0.5], [0.5, 0.5], [0.98, 0.5], [0.5, 0.98]])

    sides = label_sides(["carpet", "cork", "tile", "cloth"], places)

    assert sides == ["left", "right", "left", "top"]  # right of carpet is cork; tile and cloth are at edges
