"""Three representations of one autoregressive filter, and the conversions between them.

Of order p, ``A(z) = 1 + a_1 z^-1 + … + a_p z^-p``, it is

- its **polynomial**, float64, shape (p + 1,), a_0 = 1;
- its **reflection coefficients**, float64, shape (p,): stable (all roots inside the unit circle) exactly if all are
  within (-1, 1). Here ``A_m(z) = A_{m-1}(z) + k_m z^-m A_{m-1}(1/z)``;
- its **line spectral frequencies**, float64, shape (p,), rad/sample, ascending within (0, pi): the angles of the roots
  of ``P(z) = A(z) + z^-(p+1) A(1/z)`` and of ``Q(z) = A(z) - z^-(p+1) A(1/z)``, which alternate and lie on the unit
  circle exactly if A is stable (Itakura 1975; Soong & Juang 1984). Any ascending set is some stable filter, so a mean
  of two sets is too, which makes mixing safe.

Kabal & Ramachandran (1986) search the roots on a grid of a Chebyshev series; at order 60 roots lie closer than a grid,
and the polynomial's coefficients have lost them. Instead both conversions here stay with orthogonal matrices: P and Q
are the characteristic polynomials of the orthogonal Hessenberg matrix of the reflection coefficients with a last one of
+1 or -1 (Ammar, Gragg & Reichel 1986), whose eigenvalues are perfectly conditioned; and the way back is the inverse
eigenvalue problem, a Householder reduction to Hessenberg form. No polynomial is formed.

References
----------
- Itakura, F. (1975). Line spectrum representation of linear predictor coefficients of speech signals. J. Acoust. Soc.
  Am. 57, S35. doi 10.1121/1.1995189
- Soong, F. K. & Juang, B.-H. (1984). Line spectrum pair (LSP) and speech data compression. Proc. ICASSP, 37-40.
- Kabal, P. & Ramachandran, R. P. (1986). The computation of line spectral frequencies using Chebyshev polynomials. IEEE
  Trans. Acoust., Speech, Signal Process. 34(6), 1419-1426. doi 10.1109/TASSP.1986.1164983
- Ammar, G. S., Gragg, W. B. & Reichel, L. (1986). On the eigenproblem for orthogonal matrices. Proc. 25th IEEE Conf.
  Decision and Control, 1963-1966.
- Kay, S. M. (1988). Modern Spectral Estimation: Theory and Application. Prentice Hall. Ch. 6.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigvals, hessenberg

from tactogram.errors import ParameterError

Array = NDArray[np.float64]

LEAST_GAP = 1e-14
"""Least distance of two line spectral frequencies, rad/sample, above rounding."""
LARGEST_REFLECTION = 1 - 1e-12
"""Limit of reflection coefficients against rounding up to 1."""


def polynomial_of_reflection(reflection: ArrayLike) -> Array:
    """Return the polynomial, shape (order + 1,), of reflection coefficients (step-up recursion; Kay 1988, Ch. 6)."""
    polynomial = np.ones(1)
    for k in np.asarray(reflection, np.float64):
        padded = np.append(polynomial, 0.0)
        polynomial = padded + k * padded[::-1]
    return polynomial


def reflection_of_polynomial(polynomial: ArrayLike) -> Array:
    """Return the reflection coefficients of a polynomial (the step-down recursion; Kay 1988, Ch. 6).

    A `ParameterError` if its first coefficient is not 1, or a root is not inside the unit circle.
    """
    a = np.array(polynomial, np.float64)
    if a.ndim != 1 or a.size == 0 or a[0] != 1:
        raise ParameterError.must("polynomial", "be one row that begins with 1", _begin(a))
    reflection = np.zeros(a.size - 1)
    for m in range(a.size - 1, 0, -1):
        k = a[m]
        if not abs(k) < 1:
            raise ParameterError.must(
                "filter", f"be stable (roots inside the unit circle), got reflection coefficient {k:g}"
            )
        reflection[m - 1] = k
        a = (a[:m] - k * a[m:0:-1]) / (1 - k * k)
    return reflection


def line_spectrum_of_reflection(reflection: ArrayLike) -> Array:
    """Return the line spectral frequencies (rad/sample, ascending) of reflection coefficients within (-1, 1)."""
    k = np.asarray(reflection, np.float64)
    if k.ndim != 1 or not np.all(np.abs(k) < 1):
        raise ParameterError(f"reflection coefficients must be one row within (-1, 1), got {_begin(k)}")
    # P's p + 1 roots hold -1 if p is even; Q's hold +1, and -1 if p is odd. The rest are pairs.
    lines = np.empty(k.size)
    lines[0::2] = _angles(np.append(k, 1.0))[: 2 * lines[0::2].size : 2]
    lines[1::2] = _angles(np.append(k, -1.0))[1 : 1 + 2 * lines[1::2].size : 2]
    return _apart(lines)


def reflection_of_line_spectrum(lines: ArrayLike) -> Array:
    """Return the reflection coefficients of line spectral frequencies (rad/sample).

    A `ParameterError` if they do not ascend strictly within (0, pi): the filter would not be stable.
    """
    w = np.asarray(lines, np.float64)
    if w.ndim != 1 or not np.all(np.diff(np.concatenate(([0.0], w, [np.pi]))) > 0):
        raise ParameterError(
            f"line spectral frequencies must ascend strictly within (0, pi), got {_begin(w)}"
        )
    if w.size == 0:
        return np.zeros(0)
    p_pairs, q_pairs = w[0::2], w[1::2]
    p_real, q_real = ([-1.0], [1.0]) if w.size % 2 == 0 else ([], [1.0, -1.0])
    weights = _weights(p_pairs, p_real, q_pairs, q_real)
    # In the basis of P's roots, shift by one sample is a rotation by each angle: an orthogonal matrix ...
    size = w.size + 1
    shift = np.zeros((size, size))
    for row, angle in zip(range(0, size - 1, 2), p_pairs, strict=False):
        c, s = np.cos(angle), np.sin(angle)
        shift[row : row + 2, row : row + 2] = [[c, -s], [s, c]]
    for row, root in zip(range(2 * p_pairs.size, size), p_real, strict=True):
        shift[row, row] = root
    # ... whose Hessenberg form, begun at the weights, holds the reflection coefficients.
    start = np.zeros(size)
    start[0 : 2 * p_pairs.size : 2] = np.sqrt(2 * weights[: p_pairs.size])
    start[2 * p_pairs.size :] = np.sqrt(weights[p_pairs.size :])
    mirror = np.eye(size)
    mirror[:, 0] = start / np.linalg.norm(start)
    mirror, _ = np.linalg.qr(mirror)
    return _schur_parameters(hessenberg(mirror.T @ shift @ mirror))


def _angles(schur: Array) -> Array:
    """Return the angles, as ascending absolute values, of the orthogonal Hessenberg matrix of ``schur``."""
    matrix = np.eye(schur.size)
    matrix[-1] *= -schur[-1]
    for row in range(schur.size - 2, -1, -1):
        k = schur[row]
        c = np.sqrt((1 - k) * (1 + k))
        matrix[row : row + 2] = np.array([[-k, c], [c, k]]) @ matrix[row : row + 2]
    angles: Array = np.sort(np.abs(np.angle(eigvals(matrix))))
    return angles


def _apart(lines: Array) -> Array:
    """Return ``lines`` with neighbours at least `LEAST_GAP` apart and off the ends."""
    steps = LEAST_GAP * np.arange(1, lines.size + 1)
    up = np.maximum.accumulate(np.maximum(lines, LEAST_GAP) - steps) + steps
    back = np.pi - steps[::-1]
    apart: Array = np.minimum(up, back)
    return apart


def _weights(p_pairs: Array, p_real: list[float], q_pairs: Array, q_real: list[float]) -> Array:
    """Return the weight of each root of P (pairs, then real) in the partial fractions of Q / P."""
    p_angles = np.concatenate((p_pairs, -p_pairs, np.angle(p_real)))
    q_angles = np.concatenate((q_pairs, -q_pairs, np.angle(q_real)))
    roots = np.concatenate((p_pairs, np.angle(p_real)))
    to_q = np.abs(np.sin((roots[:, None] - q_angles) / 2))
    to_p = np.abs(np.sin((roots[:, None] - p_angles) / 2))
    to_p[to_p == 0] = 1.0
    weights: Array = np.exp(np.log(to_q).sum(1) - np.log(to_p).sum(1))
    twice = np.concatenate((np.full(p_pairs.size, 2.0), np.ones(len(p_real))))
    shares: Array = weights / (weights @ twice)
    return shares


def _schur_parameters(matrix: Array) -> Array:
    """Return the reflection coefficients of an orthogonal Hessenberg matrix, by peeling off rotations."""
    rest = matrix.copy()
    size = len(rest)
    coefficients = np.empty(size - 1)
    for row in range(size - 1):
        c, s = rest[row, row], rest[row + 1, row]
        length = np.hypot(c, s)
        c, s = c / length, s / length
        coefficients[row] = -c
        if s < 0:
            rest[row + 1] *= -1
            rest[:, row + 1 : row + 2] *= -1
            s = -s
        rest[row : row + 2] = np.array([[c, s], [s, -c]]) @ rest[row : row + 2]
    reflection: Array = np.clip(coefficients[::-1], -LARGEST_REFLECTION, LARGEST_REFLECTION)
    return reflection


def _begin(values: NDArray[np.float64]) -> str:
    text = ", ".join(f"{v:g}" for v in np.ravel(values)[:4])
    return f"[{text}{', …' if np.size(values) > 4 else ''}] of shape {np.shape(values)}"
