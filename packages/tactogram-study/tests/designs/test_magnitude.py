def test_magnitude_with_a_standard_shows_it_as_a(make_study, taken, trials):
    pages, _ = taken(make_study({"kind": "magnitude", "standard": "cork-recorded", "modulus": 50}))
    assert all(page.slot("A").stimulus.name == "cork-recorded" for page in trials(pages))
    assert "A counts as 50" in trials(pages)[0].text.texts["en"]
    assert (
        trials(pages)[0].questions[0].stimulus != "cork-recorded"
        or trials(pages)[0].questions[0].condition == "generated"
    )
