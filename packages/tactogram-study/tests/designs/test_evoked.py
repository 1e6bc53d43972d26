from tactogram_study.trials import Participant


def test_each_image_of_a_set_is_judged_and_sets_go_round(make_study, taken, trials):
    images = [{"name": f"i{n}", "image": "a.png"} for n in range(9)]
    study = make_study("evoked", stimuli=images)
    sets = []
    for number in (1, 2, 3, 4):
        pages, _ = taken(study, Participant(f"P{number}", number))
        sets.append({page.questions[0].stimulus for page in trials(pages)})
    assert [len(own) for own in sets] == [3, 3, 3, 3]
    assert sets[0] | sets[1] | sets[2] == {f"i{n}" for n in range(9)}
    assert sets[0] == sets[3]
