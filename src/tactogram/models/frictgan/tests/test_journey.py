"""Path of a finger over a photograph, and the joint spectrogram of its windows."""

import torch

from tactogram.models.frictgan.journey import journey, spliced


def test_a_finger_turns_round_at_the_edges():
    assert journey(100, 40, 0.5, 8) == [
        (0, False), (20, False), (40, False), (60, False), (40, True), (20, True), (0, False), (20, False),
    ]  # fmt: skip
    assert journey(40, 40, 0.5, 3) == [(0, False)] * 3


def test_splicing_keeps_what_all_windows_agree_on():
    whole = torch.rand(1, 5, 3 * 4 + 9)
    windows = torch.stack([whole[..., 4 * k : 4 * k + 9] for k in range(4)])
    torch.testing.assert_close(spliced(windows, 4), whole)
    assert spliced(windows[:1], 4).shape == (1, 5, 9)
