"""The bit-true model and the coefficient generator on numpy arrays: what a bench of Hoverlock's own RTL compares with.

>>> assert np.array_equal(received, models.features(frame, thresholds))
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import BitTrue, lerp_coefficients, look_ahead_of

__all__ = ["FEATURE", "Coefficients", "coefficients", "design_point", "features", "look_ahead", "planes", "records"]

FEATURE = np.dtype([
    ("x", "<u2"),
    ("y", "<u2"),
    ("response", "<u2"),
    ("flags", "<u2"),
    ("neighbours", "<u2", (4,)),
    ("descriptor", "<u4", (4,)),
])
"""The 256 bits of a feature record as the hardware sends them. Flags: bit 0 the scale, bit 1 the polarity. Neighbours:
left, right, upper, lower. Descriptor: MaxLBP of both scales, then their signs."""


@lru_cache(maxsize=8)
def _model(design: str | None) -> BitTrue:
    return BitTrue(design)


def design_point(design: str | None = None) -> str:
    """The design point as TOML: the default, changed by what a text says.

    >>> print(design_point())  # doctest: +SKIP
    """
    return _model(design).design


def features(
    frame: ArrayLike, thresholds: tuple[int, int] | None = None, *, design: str | None = None
) -> NDArray[np.void]:
    """All features of a frame of 16-bit pixels, in the hardware's order, as a structured array of ``FEATURE``.

    Thresholds are those of the first frame unless given.

    >>> found = models.features(frame, (200, 150))
    >>> found["x"], found["response"], found["flags"] & 1
    """
    model = _model(design)
    first, second = model.initial_thresholds if thresholds is None else thresholds
    packed = model.features(_pixels(frame), (int(first), int(second)))
    return np.ascontiguousarray(packed).view(FEATURE).reshape(-1)


def records(words: ArrayLike) -> NDArray[np.void]:
    """What the hardware sent, eight 32-bit words a record, the lowest first, as a structured array of ``FEATURE``; each
    frame ends with a trailer.

    >>> *found, trailer = models.records(session.transfer(frame, "video_", "feature_", packet=frame.size, packets=1))
    >>> assert np.array_equal(found, models.features(frame, thresholds))
    """
    array = np.ascontiguousarray(words, dtype="<u4")
    if array.ndim != 2 or array.shape[1] != 8:
        raise ValueError(f"a record has 8 words: an array of rows of 8 is wanted, not of shape {array.shape}")
    return array.view(FEATURE).reshape(-1)


def planes(frame: ArrayLike, *, design: str | None = None) -> dict[str, NDArray[Any]]:
    """Every plane of the model: ``smoothed0..2`` (state LSB), and for each scale ``signed_dog``, ``dog``, ``positive``,
    ``max_dog``.

    >>> models.planes(frame)["dog0"].max()
    """
    return _model(design).planes(_pixels(frame))


@dataclass(frozen=True)
class Coefficients:
    """The lerp cells of one smoother: the pole ``a``, the gain ``g`` and the look-ahead gains ``g_j`` as integers.

    >>> coefficients(2.0, 5).g_j
    (40315, 47101, 56830, 64033, 65500)
    """

    sigma: float
    frac_bits: int
    a: float
    g: int
    g_j: tuple[int, ...]
    saturated: tuple[int, ...]


def coefficients(sigma: float, look_ahead: int, frac_bits: int = 16) -> Coefficients:
    """Designs the first-order smoother of a sigma.

    >>> coefficients(2.0, 5).g
    24536
    """
    a, g, g_j, saturated = lerp_coefficients(sigma, look_ahead, frac_bits)
    return Coefficients(sigma, frac_bits, a, g, tuple(g_j), tuple(saturated))


def look_ahead(a: float, error: float) -> int:
    """The shortest look-ahead that leaves out no more than ``error`` of the sum, as the number of doubling steps.

    >>> look_ahead(0.5, 0.5 ** 8)
    3
    """
    return look_ahead_of(a, error)


def _pixels(frame: ArrayLike) -> NDArray[np.uint16]:
    array = np.asarray(frame)
    if array.ndim != 2:
        raise ValueError(f"a frame has two dimensions, rows and columns, not {array.ndim}")
    if array.dtype != np.uint16:
        if array.dtype.kind not in "ui" or (array.size and (array.min() < 0 or array.max() > 65535)):
            raise ValueError(f"pixels are 16-bit words, not {array.dtype}")
        array = array.astype(np.uint16)
    return np.ascontiguousarray(array)
