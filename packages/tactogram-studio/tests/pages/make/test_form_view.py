from tactogram.datasets.ratings.words import WORDS
from tactogram.model import ImageKind
from tactogram_studio.pages.make.form_view import scale_text

IMAGES = ImageKind(WORDS, (0.0, 1.0), ("a",))


def test_the_sliders_of_words_are_explained_by_the_runs_own_scale():
    assert scale_text((1.0, 7.0)) == scale_text(None) == "1 (not at all) to 7 (very)."
    assert "4 half, 7 everybody" in scale_text(IMAGES.scale)
    assert "own ratings, 0 to 100," in scale_text((0.0, 100.0))
