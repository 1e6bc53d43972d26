"""A store as a sequence, and as arrays for other libraries."""

import numpy as np
import pytest
import torch
from sklearn.model_selection import GroupKFold

from tactogram.datasets import Recording, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal


def recording(seed, samples=200, *, material="cork", session=None, rate=1000.0):
    wave = np.random.default_rng(seed).standard_normal((3, samples))
    streams = {"acceleration": Signal(wave, rate, "m/s^2")}
    if seed % 2:
        streams["force"] = Signal(wave[:1, ::10], rate / 10, "N")
    return Recording(material=material, session=session, streams=streams)


def stored(folder, recordings):
    return create_store(folder / "store", recordings, name="test", licence="CC0-1.0")


def test_recordings_come_by_place_id_slice_and_loop(tmp_path):
    made = [recording(seed) for seed in range(5)]
    store = stored(tmp_path, made)
    assert repr(store) == f"<Store 'test': 5 recordings, in {tmp_path / 'store'}>"
    assert [one.id for one in store] == [one.id for one in made]
    assert store[1].id == store[made[1].id].id == made[1].id
    assert store[-1].id == made[4].id
    assert [one.id for one in store[1:4]] == [one.id for one in made[1:4]]
    np.testing.assert_array_equal(store[2].stream("acceleration"), made[2].stream("acceleration"))
    with pytest.raises(IndexError, match="below 5, got 5"):
        store[5]
    with pytest.raises(ParameterError, match="one of the 5 in"):
        store["nothing"]


def test_arrays_are_as_scikit_learn_and_pytorch_take_them(tmp_path):
    made = [recording(n, material="ab"[n % 2], session=f"s{n // 2}") for n in range(6)]
    X, y, groups = stored(tmp_path, made).to_numpy()
    assert (X.shape, X.dtype) == ((6, 3, 200), np.float32)
    np.testing.assert_array_equal(X[4], made[4].stream("acceleration").samples)
    assert y.tolist() == ["a", "b"] * 3
    assert groups.tolist() == ["s0", "s0", "s1", "s1", "s2", "s2"]
    for train, test in GroupKFold(3).split(X, y, groups):
        assert not set(groups[train]) & set(groups[test])
    assert torch.utils.data.TensorDataset(torch.from_numpy(X))[3][0].shape == (3, 200)


def test_recordings_without_the_stream_or_a_group(tmp_path):
    made = [recording(n, material=None, session="s" if n < 2 else None) for n in range(4)]
    X, y, groups = stored(tmp_path, made).to_numpy("force", seconds=0.1)
    assert X.shape == (2, 1, 10)
    assert y.tolist() == ["", ""]
    assert groups.tolist() == ["s", made[3].id]


def test_what_makes_no_array_says_how_it_can_be_one(tmp_path):
    store = stored(tmp_path, [recording(0, 200), recording(2, 300)])
    with pytest.raises(ParameterError, match=r"last 0\.2 to 0\.3 s; choose seconds, 0\.2 at most"):
        store.to_numpy()
    assert store.to_numpy(seconds=0.15).X.shape == (2, 3, 150)
    with pytest.raises(ParameterError, match=r"at most 0\.2, the shortest recording; got 0\.25"):
        store.to_numpy(seconds=0.25)
    with pytest.raises(ParameterError, match="stream must be one of acceleration, got 'sound'"):
        store.to_numpy("sound")
    with pytest.raises(ParameterError, match="such as session or subject, got 'day'"):
        store.to_numpy(by="day")


def test_other_rates_are_told(tmp_path):
    store = stored(tmp_path, [recording(0, 200), recording(2, 200, rate=500.0)])
    with pytest.raises(ParameterError, match="one rate and the same axes, got 500 of x,y,z; 1000 of x,y,z"):
        store.to_numpy(seconds=0.1)
