import pytest
from tests.signal.io.foreign import CASES, check


@pytest.mark.parametrize("example", CASES, ids=lambda example: example.name)
def test_tables_of_other_programs_are_read_right_or_asked_about(example, tmp_path):
    verdict = check(example, tmp_path)
    assert verdict.good, f"{example.name} {verdict.word}: {verdict.differs}"


def test_each_layout_is_there_once():
    names = [example.name for example in CASES]
    assert len(set(names)) == len(names) >= 80
