from matplotlib.figure import Figure

from tactogram_study.analysis import figures
from tactogram_study.analysis.figures import DEFAULT_FONT, font_with, letter


def test_a_font_has_all_letters_or_none_is_named(monkeypatch):
    assert font_with(["cork", "Öl", ""]) == DEFAULT_FONT
    assert font_with(["コルク"]) in (None, *figures.EAST_ASIAN)
    monkeypatch.setattr(figures, "EAST_ASIAN", ())
    assert font_with(["cork", "コルク"]) is None


def test_every_text_of_a_figure_takes_the_font():
    figure = Figure()
    axes = figure.add_subplot()
    axes.set_xticks([0, 1], ["コルク", "布"])
    axes.set_title("tile")
    letter(figure, "A font")
    texts = [*axes.get_xticklabels(), axes.title]
    assert [text.get_fontfamily() for text in texts] == [[DEFAULT_FONT, "A font"]] * 3
