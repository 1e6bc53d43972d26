import json

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram_study.session.device_facts import device_columns, fact_description, valid_facts
from tactogram_study.session.store import SessionStore

FACTS = {"px_per_mm": 6.25, "refresh_hz": 59.94, "touch": True, "finger_speed_mm_s": [480, 512.5]}


def test_facts_of_an_answer_stand_in_its_row(store):
    code = store.enrol("P1", device={"px_per_mm": 3.78, "pointer": "mouse"}).code
    store.submit(code, "consent", {"consent": "agreed"}, rt_ms={"": 5}, device=FACTS)
    [row] = store.answers()
    assert {name: value for name, value in row.more.items() if name.startswith("device_")} == {
        "device_px_per_mm": "6.25",
        "device_refresh_hz": "59.94",
        "device_touch": "true",
        "device_finger_speed_mm_s": "480 512.5",
    }
    assert [one["token"] for one in store.device_log(code)] == ["", "consent"]
    assert store.device(code) == {"pointer": "mouse", **FACTS}


def test_facts_are_stored_once_as_the_answer_is(store):
    code = store.enrol().code
    for number in (1, 2):
        store.submit(code, "consent", {"consent": "agreed"}, device={"px_per_mm": number})
    assert store.device(code) == {"px_per_mm": 1}


@pytest.mark.parametrize(
    "odd",
    [
        float("nan"),
        float("inf"),
        10**20,
        None,
        "",
        " \n",
        [],
        ["a"],
        [1, float("nan")],
        [1] * 201,
        {"a": {"b": 1}},
    ],
)
def test_what_cannot_be_kept_is_left_out_and_the_rest_is_kept(odd):
    assert valid_facts({"odd": odd, "bad name": 1, "x" * 50: 1, "px_per_mm": 4}) == {"px_per_mm": 4}


def test_tables_within_are_laid_flat_and_texts_are_one_short_line():
    found = valid_facts({"screen": {"width_px": 1440, "note": "a\tb\n" + "c" * 300}})
    assert found["screen_width_px"] == 1440
    assert found["screen_note"].startswith("a b c")
    assert len(found["screen_note"]) == 200
    assert len(valid_facts({f"fact{n}": n for n in range(100)})) == 40


def test_what_pages_send_is_described():
    assert (
        fact_description("finger_speed_mm_s_a")
        == "Mean speed of the finger over the area, mm/s, as measured; of A"
    )
    assert fact_description("plays_X") == "How often it was played; of X"
    assert fact_description("odd") == "odd, as the page sent it"


def test_a_number_is_written_with_six_digits():
    assert device_columns({"px_per_mm": 1 / 3}) == {"device_px_per_mm": "0.333333"}


def test_who_goes_on_with_another_device_has_its_facts(store):
    code = store.enrol(device={"px_per_mm": 3.78}).code
    store.log_device(code, {"px_per_mm": 5.0})
    assert store.device(code) == {"px_per_mm": 5.0}


def test_withdrawal_deletes_device_facts(store):
    code = store.enrol("GONE1", device={"pointer": "unlikelytext"}).code
    store.withdraw(code)
    left = b"".join(path.read_bytes() for path in store.path.parent.glob("answers.sqlite*"))
    assert b"unlikelytext" not in left


def test_the_language_of_a_participant_can_change(store):
    code = store.enrol(language="ja").code
    store.set_language(code, "en")
    assert store.participant(code).language == "en"
    with pytest.raises(ParameterError, match="language must be one of en, ja, got 'fr'"):
        store.set_language(code, "fr")


@pytest.mark.parametrize("version", [2, 9])
def test_a_folder_of_another_version_is_refused(store, version):
    store._connection.execute(f"PRAGMA user_version = {version}")
    with pytest.raises(
        DataError, match=f"is of version {version}, this program reads version 4; open it with"
    ):
        SessionStore(store.path.parent)


def test_facts_are_json_that_others_read(store):
    code = store.enrol(device={"name": "日本"}).code
    [row] = store._connection.execute("SELECT facts FROM device").fetchall()
    assert json.loads(row[0]) == {"name": "日本"}
    assert store.device(code) == {"name": "日本"}
