import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import SignalKind
from tactogram.nn.latent_pieces import crossfaded_pieces, given_latent, uniform_latents

KIND = SignalKind(1000.0, "N", ("x", "y"))
PIECE, OVERLAP = 400, 50


def noises(asked):
    """Return pieces of noise, each by its number, and record the requests."""

    def make(first, count):
        asked.append((first, count))
        return np.stack(
            [
                np.random.default_rng(number).standard_normal((2, PIECE)).astype(np.float32)
                for number in range(first, first + count)
            ]
        )

    return make


def test_pieces_are_made_once_in_growing_batches():
    asked = []
    made = crossfaded_pieces(noises(asked), KIND, length=10 * (PIECE - OVERLAP), overlap=OVERLAP)
    assert made.shape == (2, 10 * (PIECE - OVERLAP))
    assert asked == [(0, 1), (1, 1), (2, 2), (4, 4), (8, 8)]


def test_outside_the_crossfades_a_signal_is_its_pieces():
    made = crossfaded_pieces(noises([]), KIND, length=1500, overlap=OVERLAP)
    for number in range(4):
        start = number * (PIECE - OVERLAP)
        inner = slice(start + OVERLAP * (number > 0), start + PIECE - OVERLAP)
        piece = np.random.default_rng(number).standard_normal((2, PIECE)).astype(np.float32)
        np.testing.assert_allclose(
            made[:, inner], piece[:, inner.start - start : inner.stop - start], atol=1e-6
        )


def test_latents_are_drawn_by_number_unless_given():
    given = torch.full((3,), 0.5)
    both = uniform_latents(0, 4, 3, given={2: given}, rng=np.random.default_rng)
    later = uniform_latents(1, 3, 3, given={}, rng=np.random.default_rng)
    torch.testing.assert_close(both[2], given)
    torch.testing.assert_close(both[[1, 3]], later[[0, 2]])
    assert both.abs().max() <= 1


def test_a_latent_is_checked():
    assert given_latent({}, 2) == {}
    (piece,) = given_latent({"latent": [0.5, -1]}, 2, piece=1)
    assert piece == 1
    for wrong in ([0.5], [0.5, 1.1], [0.5, float("nan")]):
        with pytest.raises(ParameterError, match="latent must be 2 numbers in -1 to 1"):
            given_latent({"latent": wrong}, 2)
