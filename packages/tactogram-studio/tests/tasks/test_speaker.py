from tactogram_studio.tasks.speaker import log_played, recently_played


def test_what_was_played_is_kept_in_order_and_survives_a_cut_line(tmp_path):
    for number in range(7):
        log_played(tmp_path, {"title": str(number)})
    with (tmp_path / "played.jsonl").open("a") as file:
        file.write('{"title": "cut')
    assert [line["title"] for line in recently_played(tmp_path, 3)] == ["6", "5", "4"]
