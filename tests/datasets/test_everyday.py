"""Names of everyday materials, and what is known of them."""

from tactogram.datasets.everyday import KIND_OF, MEASURED, SYNONYMS, known_from


def test_other_names_belong_to_one_material():
    assert set(SYNONYMS) <= set(KIND_OF)
    others = [other for called in SYNONYMS.values() for other in called]
    assert len(set(others)) == len(others)
    assert SYNONYMS["denim"] == ("jeans",)


def test_each_is_of_one_kind_and_says_what_it_was_set_from():
    assert set(KIND_OF.values()) == set(MEASURED)
    assert "the mean of 14 real materials of the kind fabric" in known_from("velvet")
    assert "of 60 real materials of all kinds" in known_from("oak")
