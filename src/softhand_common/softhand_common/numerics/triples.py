"""Vectors and rotations of a single point inside compiled kernels.

Vectors are tuples of three numbers and matrices tuples of three rows, which the compiler keeps in
registers. Vectors that are only read may also be rows of arrays. `vector_at` and `matrix_at` read
from arrays (3, n) and (3, 3, n) over points.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np

from softhand_common.numerics.compiled import compiled, without_allocation

SMALL_SQUARE = 0.5  # [rad2] below which the coefficients are computed from their series
SERIES_TERMS = 7  # exact to rounding
SERIES = np.array(  # (SERIES_TERMS, 2): of b and c
    [[(-1) ** k / factorial(2 * k + more) for more in (2, 3)] for k in range(SERIES_TERMS)]
)
IDENTITY_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# for annotations only: numba sees tuples
Vector = Any
Matrix = Any


@compiled
def vector_at(array: Any, point: int) -> Vector:
    """The vector of a point in an array (3, n)."""
    return (array[0, point], array[1, point], array[2, point])


@compiled
def matrix_at(array: Any, point: int) -> Matrix:
    """The matrix of a point in an array (3, 3, n)."""
    return (
        vector_at(array[0], point),
        vector_at(array[1], point),
        vector_at(array[2], point),
    )


@compiled
def scaled(factor: float, a: Vector) -> Vector:
    """A number times a vector."""
    return (factor * a[0], factor * a[1], factor * a[2])


@without_allocation
def plus(a: Vector, b: Vector) -> Vector:
    """Sum of vectors."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@without_allocation
def minus(a: Vector, b: Vector) -> Vector:
    """Difference of vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@without_allocation
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@without_allocation
def cross(a: Vector, b: Vector) -> Vector:
    """Cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@compiled
def largest(a: Vector) -> float:
    """Largest absolute value of the three components."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@without_allocation
def transposed(m: Matrix) -> Matrix:
    """Transpose."""
    return (
        (m[0][0], m[1][0], m[2][0]),
        (m[0][1], m[1][1], m[2][1]),
        (m[0][2], m[1][2], m[2][2]),
    )


@without_allocation
def apply(m: Matrix, a: Vector) -> Vector:
    """Matrix times vector."""
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


@without_allocation
def multiply(m: Matrix, n: Matrix) -> Matrix:
    """Product of matrices."""
    columns = transposed(n)
    return (apply(columns, m[0]), apply(columns, m[1]), apply(columns, m[2]))


@compiled
def inverse(m: Matrix) -> Matrix:
    """Inverse of a matrix."""
    first, second, third = cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])
    per_volume = 1.0 / dot(m[0], first)
    return transposed(
        (scaled(per_volume, first), scaled(per_volume, second), scaled(per_volume, third))
    )


@compiled
def coefficients(square: float) -> tuple[float, float]:
    """b = (1 - cos t)/t**2 and c = (t - sin t)/t**3 of a squared angle t**2 [rad2].

    Below SMALL_SQUARE they are sums of 1/2 - t**2/24 + ... and 1/6 - t**2/120 + ...
    """
    if square >= SMALL_SQUARE:
        angle = np.sqrt(square)
        return (1.0 - np.cos(angle)) / square, (angle - np.sin(angle)) / (square * angle)
    b, c = SERIES[SERIES_TERMS - 1, 0], SERIES[SERIES_TERMS - 1, 1]
    for term in range(SERIES_TERMS - 2, -1, -1):
        b, c = b * square + SERIES[term, 0], c * square + SERIES[term, 1]
    return b, c


@compiled
def quadratic(a: Vector, first: float, second: float) -> Matrix:
    """1 + first*[a] + second*[a]**2, where [a] v = a x v.

    Let t be the length of a, and b and c what `coefficients` returns for t**2. The rotation matrix
    of the rotation vector a has first = 1 - t**2*c and second = b; its left Jacobian J has first =
    b and second = c, with exp(a + da) = exp(J da) exp(a) to first order.
    """
    x, y, z = first * a[0], first * a[1], first * a[2]
    p, q, r = scaled(second, a)
    rest = 1.0 - second * dot(a, a)
    return (
        (rest + p * a[0], p * a[1] - z, p * a[2] + y),
        (q * a[0] + z, rest + q * a[1], q * a[2] - x),
        (r * a[0] - y, r * a[1] + x, rest + r * a[2]),
    )


@compiled
def rotation(a: Vector) -> Matrix:
    """Rotation matrix of a rotation vector [rad]."""
    square = dot(a, a)
    b, c = coefficients(square)
    return quadratic(a, 1.0 - square * c, b)


@compiled
def left_jacobian(a: Vector) -> Matrix:
    """Left Jacobian of a rotation vector [rad]: see `quadratic`."""
    b, c = coefficients(dot(a, a))
    return quadratic(a, b, c)


@compiled
def rotation_vector(m: Matrix) -> Vector:
    """Rotation vector [rad] of a rotation matrix of less than half a turn."""
    sine = (0.5 * (m[2][1] - m[1][2]), 0.5 * (m[0][2] - m[2][0]), 0.5 * (m[1][0] - m[0][1]))
    length = np.sqrt(dot(sine, sine))
    cosine = 0.5 * (m[0][0] + m[1][1] + m[2][2] - 1.0)
    return scaled(1.0 if length < 1e-8 else np.arctan2(length, cosine) / length, sine)


@compiled
def about_y(m: Matrix, sine: float, cosine: float) -> Matrix:
    """Product of a rotation matrix and the rotation about y by an angle, given by its sine and
    cosine.
    """
    return (
        (cosine * m[0][0] - sine * m[0][2], m[0][1], sine * m[0][0] + cosine * m[0][2]),
        (cosine * m[1][0] - sine * m[1][2], m[1][1], sine * m[1][0] + cosine * m[1][2]),
        (cosine * m[2][0] - sine * m[2][2], m[2][1], sine * m[2][0] + cosine * m[2][2]),
    )
