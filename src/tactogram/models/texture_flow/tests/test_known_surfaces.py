"""Surfaces that a vibration, a photograph or a material stands for."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.models.texture_flow import build
from tactogram.models.texture_flow.tests.test_signal_learner import EXAMPLES, KIND, SMALL, recording, trained
from tactogram.signal import Image
from tactogram.training.loop import fit


def test_a_recording_stands_for_its_surface():
    learner, stroke = trained(), recording("tile", 9, seconds=1.0)
    signal = learner.generate({"vibration": stroke.signal}, seconds=4, seed=1)
    assert signal.samples[0].std() == pytest.approx(stroke.signal.samples[0].std(), rel=0.25)
    with pytest.raises(ParameterError, match="material and vibration describe the surface twice"):
        learner.generate({"material": "cork", "vibration": stroke.signal}, seed=0)
    with pytest.raises(ParameterError, match="condition 'material' is needed, or vibration instead"):
        learner.generate({}, seed=0)
    with pytest.raises(ParameterError, match="at least 80 samples, got none of the vibration"):
        learner.generate({"vibration": stroke.signal.cut(0, 79)}, seed=0)


def test_a_photograph_stands_for_the_material_it_shows():
    rng = np.random.default_rng(0)
    plain, striped = rng.integers(120, 136, (48, 48, 3)), rng.integers(120, 136, (48, 48, 3))
    striped[::4] += 80
    shown = {
        name: [Image(x.astype(np.uint8))] for name, x in zip(KIND.materials, (plain, striped), strict=True)
    }
    examples = [Example(e.id, e.signal, e.material, {}, shown[str(e.material)]) for e in EXAMPLES]
    learner = build(SMALL.model_copy(update={"steps": 1}), KIND, seed=0)
    fit(learner, examples, seed=0)
    again = build(SMALL, KIND, seed=1)
    again.load_state(learner.state())
    turned = Image(np.ascontiguousarray(shown["tile"][0].pixels.swapaxes(0, 1)))
    name, probability = again.classify_photograph(turned)
    assert (name, probability > 0.9) == ("tile", True)
    generated, tile = (
        again.generate(c, seconds=2, seed=0).samples for c in ({"image": turned}, {"material": "tile"})
    )
    assert generated.std() == pytest.approx(tile.std(), rel=0.3)


def test_a_run_without_photographs_refuses_one_and_says_what_to_give_instead():
    refused = (
        "condition 'image' was not learned by this run; give material (by name, or a text that describes it) or "
        "vibration, or train on recordings with photographs of two materials or more"
    )
    with pytest.raises(ParameterError) as error:
        trained().generate({"image": Image(np.zeros((48, 48, 3), np.uint8))}, seed=0)
    assert str(error.value) == refused
