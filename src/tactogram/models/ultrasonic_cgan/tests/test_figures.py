"""Figure 6."""

import numpy as np


def test_figure_6_has_the_spectrum_that_goes_in_and_the_one_that_comes_out(learner):
    surfaces, pair = learner.surfaces, learner.trained[0]
    left, right = learner.figures()["spectra"].axes[:2]
    drawn = {line.get_label(): line.get_ydata() for axes in (left, right) for line in axes.lines}
    np.testing.assert_array_equal(drawn["input"], surfaces.stored[0, 0])
    np.testing.assert_allclose(drawn["mean of plate01"], surfaces.stored[0].mean(0))
    output, _ = pair.answers(surfaces.stored[0, :1] / surfaces.sensor_scale, surfaces.means[0])
    np.testing.assert_allclose(drawn["output"], output[0].clip(0) * surfaces.display_scale)
    [nearest] = [label for label in drawn if label.startswith("nearest: signal")]
    assert any(np.array_equal(drawn[nearest], row) for row in surfaces.display)
