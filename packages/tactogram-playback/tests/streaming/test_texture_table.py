"""Tables of a texture over speed and force."""

import math

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.texture_map import TextureMap
from tactogram_playback.streaming.texture_table import TextureTable, summed


def test_a_table_is_exact_at_every_condition_that_was_recorded(table, sloping):
    for model, (speed, force) in zip(sloping.models, sloping.conditions, strict=True):
        found = table.at(speed, force)
        assert np.allclose(found.reflection, model.reflection, atol=1e-9)
        assert found.power == pytest.approx(model.power, rel=1e-9)


def test_between_its_nodes_a_table_is_the_map_to_a_fraction_of_a_db(table, sloping):
    frequency, random = np.linspace(0.02, 0.98, 200) * table.rate / 2, np.random.default_rng(0)
    found = []
    for _ in range(30):
        speed, force = (random.uniform(grid[0], grid[-1]) for grid in (table.grid.speeds, table.grid.forces))
        exact = sloping.at(
            *(v if known else None for v, known in zip((speed, force), sloping.has_conditions, strict=True))
        )
        ratio = table.at(speed, force).power_spectrum(frequency) / exact.power_spectrum(frequency)
        found.append(np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)))
    assert np.mean(found) < 0.05


def test_outside_a_table_holds_its_edge(table):
    assert np.array_equal(table.at(9999, 9).reflection, table.at(300, 1).reflection)
    assert np.array_equal(table.at(0, 0).reflection, table.at(50, 0.2).reflection)


def test_a_surface_of_one_condition_has_a_table(resonance):
    one = TextureMap([resonance(200)], [[math.nan, math.nan]])
    assert np.allclose(TextureTable(one).at(123, 4).reflection, resonance(200).reflection)


def test_summed_axes_have_the_power_of_all_at_every_frequency():
    random = np.random.default_rng(0)
    model = AutoregressiveModel(
        np.tanh(random.normal(0, 0.4, (3, 12))), np.diag([1.0, 2.0, 0.5]), 2500.0, "m/s^2", ("x", "y", "z")
    )
    one = summed(model)
    frequency = np.linspace(5, 1245, 400)
    ratio = one.power_spectrum(frequency)[0] / model.power_spectrum(frequency).sum(axis=0)
    assert np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)) < 0.5
    assert one.power[0] == pytest.approx(model.power.sum(), rel=1e-6)


def test_an_axis_that_is_not_there_is_refused(sloping):
    with pytest.raises(ParameterError, match="axis must be dft321, all or one of z, got 'q'"):
        TextureTable(sloping, axis="q")
