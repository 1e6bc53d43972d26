"""Anybody: the studio in an empty folder, touch of a few words, and a page to share."""


def test_words_are_felt_and_shared(page, saved, step):
    with step("the first page"):
        page.goto("/")
    with step("words to a picture and a sound"):
        page.get_by_label("A surface or an effect, in English").fill("corduroy")
        page.get_by_role("button", name="Make it").click()
        page.get_by_role("heading", name="corduroy, seed 0").wait_for()
        page.get_by_role("button", name="Play").first.wait_for()
    with step("the same under the finger"):
        page.goto("/touch")
        page.get_by_text("Feel an everyday material").click()
        page.get_by_label("One of 84 materials").fill("corduroy")
        page.get_by_role("option", name="corduroy", exact=True).click()
        page.wait_for_function("() => window.tactogramTouch.rows.words().includes('corduroy')")
    with step("one file to share"):
        file = saved(page.get_by_role("link", name="Save as one page"))
    assert "corduroy" in file.name
    text = file.read_text(encoding="utf-8")
    assert "<html" in text
    assert "tactogram-touch" in text
