"""Shares of evoked words."""

import numpy as np
from simulated_answers import only, simulated

from tactogram_study.analysis.findings import NOT_SHOWN, SHOWN
from tactogram_study.study_analysis import analyse


def test_evoked_shares_have_intervals_and_holm():
    rng = np.random.default_rng(0)
    truth = {"i1": 0.95, "i2": 0.5, "i3": 0.05}
    rows = [
        (p, k + 1, {"stimulus": image, "value": float(rng.random() < share)})
        for p in range(30)
        for k, (image, share) in enumerate(truth.items())
    ]
    section = only(analyse(simulated("evoked", "rough", rows)))
    table = {row["image"]: row for row in section.tables["per image and word"]}
    assert [table[image]["verdict"] for image in truth] == [SHOWN, NOT_SHOWN, SHOWN]
    assert all(table[i]["wilson_low"] < share < table[i]["wilson_high"] for i, share in truth.items())
    assert table["i1"]["n"] == 30
