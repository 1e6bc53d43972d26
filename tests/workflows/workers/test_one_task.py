"""One task on one thread."""

import pytest
import torch
from threadpoolctl import threadpool_info

from tactogram.errors import ParameterError
from tactogram.workflows.workers.one_task import attempted, one_thread


@pytest.fixture
def several_threads():
    """Let torch have two threads, for this test alone: those after it compute to the bit what one thread computes."""
    before = torch.get_num_threads()
    torch.set_num_threads(several := max(2, before))
    yield several
    torch.set_num_threads(before)


def test_a_task_is_done_on_one_thread_and_the_others_come_back(several_threads):
    threads = attempted(lambda _: (torch.get_num_threads(), [p["num_threads"] for p in threadpool_info()]), 0)
    assert threads[1] is None
    assert threads[0][0] == 1
    assert set(threads[0][1]) <= {1}
    assert torch.get_num_threads() == several_threads
    with pytest.raises(ZeroDivisionError), one_thread():
        _ = 1 / 0
    assert torch.get_num_threads() == several_threads


def test_an_error_of_the_package_is_an_outcome_and_a_bug_is_raised():
    def refuse(task):
        raise ParameterError(f"{task} is refused")

    assert attempted(refuse, "cork") == (None, "cork is refused")
    with pytest.raises(ZeroDivisionError):
        attempted(lambda task: task / 0, 1)
