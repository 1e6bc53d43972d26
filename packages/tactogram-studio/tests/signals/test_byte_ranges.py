import pytest

from tactogram_studio.signals.sound import range_response

DATA = bytes(range(10))


@pytest.mark.parametrize(
    ("asked", "status", "span", "sent"),
    [
        (None, 200, None, DATA),
        ("bytes=0-1", 206, "bytes 0-1/10", DATA[:2]),  # Safari's first
        ("bytes=7-", 206, "bytes 7-9/10", DATA[7:]),
        ("bytes=4-99", 206, "bytes 4-9/10", DATA[4:]),
        ("bytes=-3", 206, "bytes 7-9/10", DATA[7:]),
        ("bytes=-99", 206, "bytes 0-9/10", DATA),
        ("bytes=10-", 416, "bytes */10", b""),
        ("bytes=-0", 416, "bytes */10", b""),
        ("bytes=5-2", 200, None, DATA),
        ("bytes=0-1,4-5", 200, None, DATA),
        ("bytes=-", 200, None, DATA),
        ("lines=0-1", 200, None, DATA),
    ],
)
def test_one_range_of_bytes_is_answered_as_rfc_9110_has_it(asked, status, span, sent):
    answer = range_response(DATA, asked, media_type="audio/wav", headers={"cache-control": "private"})
    assert (answer.status_code, answer.body) == (status, sent)
    assert answer.headers.get("content-range") == span
    assert answer.headers["content-length"] == str(len(sent))
    assert (answer.headers["accept-ranges"], answer.headers["cache-control"]) == ("bytes", "private")
