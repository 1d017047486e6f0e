"""The bit-true model on numpy arrays.

Units: a pixel is a sample of the camera, 0 to ``2**P - 1`` for ``P`` bits; at the default design point ``P`` is 16, and a
sample is in DN (digital number: one step of a 16-bit sample). A smoothed sample is in LSB of the state,
1/4 DN at the default design point; a DoG (difference of Gaussians) is in LSB of the DoG, 1/2 DN at the default design point.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import BitTrue, emission_value

__all__ = ["FEATURE", "FEATURE_OF_THREE_PAIRS", "Planes", "design_point", "emission", "features", "planes", "records"]

_FIELDS = [
    ("x", "<u2"),
    ("y", "<u2"),
    ("response", "<u2"),
    ("flags", "<u2"),
    ("neighbours", "<u2", (4,)),
    ("descriptor", "<u4", (4,)),
]

FEATURE = np.dtype(_FIELDS)
"""The 256 bits of a feature record as the hardware sends them.

``x`` and ``y`` are in pixels; ``response`` and ``neighbours`` (left, right, upper, lower) in LSB of the DoG. Bit 0 of ``flags``
is the scale, bit 1 the polarity. ``descriptor`` has MaxLBP of both scales, then their signs."""

FEATURE_OF_THREE_PAIRS = np.dtype([*_FIELDS, ("third", "<u4", (2,))])
"""The 320 bits of a record in designs of three scale pairs: bit 2 of ``flags`` is the third scale, ``third`` has MaxLBP and
signs of the third pair."""

_RECORDS = {8: FEATURE, 10: FEATURE_OF_THREE_PAIRS}


class _PlanesOfOnePair(TypedDict):
    smoothed0: NDArray[np.uint32]
    smoothed1: NDArray[np.uint32]
    signed_dog0: NDArray[np.int32]
    dog0: NDArray[np.uint16]
    positive0: NDArray[np.bool_]
    max_dog0: NDArray[np.uint16]


class Planes(_PlanesOfOnePair, total=False):
    """All planes of a frame by name. Each has the shape of the frame; ``k`` is the scale pair, from 0 to one less than the
    ``scale_pairs`` of the design, and there is one smoothed plane more.

    Attributes
    ----------
    smoothed0, smoothed1, smoothed2, smoothed3 : ndarray of uint32
        The frame smoothed with each sigma, in LSB of the state.
    signed_dog0, signed_dog1, signed_dog2 : ndarray of int32
        ``smoothed[k] - smoothed[k + 1]``, in LSB of the state.
    dog0, dog1, dog2 : ndarray of uint16
        The magnitude of ``signed_dog``, rounded and saturated, in LSB of the DoG.
    positive0, positive1, positive2 : ndarray of bool
        Whether ``signed_dog`` is 0 or more.
    max_dog0, max_dog1, max_dog2 : ndarray of uint16
        MaxDOG, from which the descriptor is computed, in LSB of the DoG.

    >>> planes = models.planes(frame)
    >>> planes["dog0"].dtype
    dtype('uint16')
    """

    smoothed2: NDArray[np.uint32]
    smoothed3: NDArray[np.uint32]
    signed_dog1: NDArray[np.int32]
    signed_dog2: NDArray[np.int32]
    dog1: NDArray[np.uint16]
    dog2: NDArray[np.uint16]
    positive1: NDArray[np.bool_]
    positive2: NDArray[np.bool_]
    max_dog1: NDArray[np.uint16]
    max_dog2: NDArray[np.uint16]


@lru_cache(maxsize=8)
def _model(design_point: str | None) -> BitTrue:
    return BitTrue(design_point)


def design_point(changes: str | None = None) -> str:
    """Returns the design point: word lengths, sigmas, look-aheads and thresholds of the model.

    Parameters
    ----------
    changes : str, optional
        TOML text with the values that differ from the default design point.

    Returns
    -------
    str
        The whole design point as TOML text.

    Raises
    ------
    ValueError
        If the text is not TOML, or has an unknown key or an invalid value.

    >>> print(design_point())  # doctest: +SKIP
    """
    return _model(changes).design_point


def emission() -> int:
    """Returns the hash of the default design's Verilog, with which software recognises the hardware that it was built for.

    Returns
    -------
    int
        The value of the register ``emission`` (byte address 0x08): the first 32 bits of the SHA-256 of the emitted Verilog.
        In the C header it is ``HOVERLOCK_EMISSION_VALUE``, in the Rust constants ``EMISSION_VALUE``.

    >>> assert await csr.read(0x08 >> 2) == models.emission()
    """
    return emission_value()


def features(
    frame: ArrayLike, thresholds: Sequence[int] | None = None, *, design_point: str | None = None
) -> NDArray[np.void]:
    """Returns all features of a frame, in the order in which the hardware sends them.

    Parameters
    ----------
    frame : array_like of integers, shape (height, width)
        Samples of the camera, 0 to ``2**P - 1`` for the ``P`` bits of the design: 0 to 65535 at the default one.
    thresholds : sequence of int, optional
        The smallest response of a feature at each scale pair, in LSB of the DoG. Default: the thresholds of the hardware
        at the first frame.
    design_point : str, optional
        TOML text with the values that differ from the default design point.

    Returns
    -------
    ndarray of dtype ``FEATURE``, shape (features,); ``FEATURE_OF_THREE_PAIRS`` with a design of three scale pairs

    Raises
    ------
    ValueError
        If the frame does not have two dimensions of at least one pixel, has values that the design's camera cannot send,
        with another number of thresholds than the design has scale pairs, or if the design point is invalid.

    >>> found = models.features(frame, (200, 150))
    >>> found["x"], found["response"], found["flags"] & 1
    """
    model = _model(design_point)
    given = model.initial_thresholds if thresholds is None else thresholds
    return records(model.features(_pixels(frame), [int(threshold) for threshold in given]))


def records(words: ArrayLike) -> NDArray[np.void]:
    """Returns the feature records in the words that the hardware sent. The last record of each frame is its trailer.

    Parameters
    ----------
    words : array_like of uint32, shape (records, 8) or (records, 10)
        The 32-bit words of each record, the lowest word first: ten in designs of three scale pairs.

    Returns
    -------
    ndarray of dtype ``FEATURE``, shape (records,); ``FEATURE_OF_THREE_PAIRS`` of ten words

    Raises
    ------
    ValueError
        If the array does not have two dimensions, the second of length 8 or 10.

    >>> *found, trailer = models.records(session.transfer(frame, "video_", "feature_", packet=frame.size, packets=1))
    >>> assert np.array_equal(found, models.features(frame, thresholds))
    """
    array = np.ascontiguousarray(words, dtype="<u4")
    if array.ndim != 2 or array.shape[1] not in _RECORDS:
        raise ValueError(f"a record has 8 or 10 words of 32 bits: the shape is (records, 8) or (records, 10), not {array.shape}")
    return array.view(_RECORDS[array.shape[1]]).reshape(-1)


def planes(frame: ArrayLike, *, design_point: str | None = None) -> Planes:
    """Returns every plane of the model for a frame.

    Parameters
    ----------
    frame : array_like of integers, shape (height, width)
        Samples of the camera, 0 to ``2**P - 1`` for the ``P`` bits of the design: 0 to 65535 at the default one.
    design_point : str, optional
        TOML text with the values that differ from the default design point.

    Returns
    -------
    Planes
        Arrays of shape (height, width) by name; `Planes` has their dtypes and units.

    Raises
    ------
    ValueError
        As `features`.

    >>> models.planes(frame)["dog0"].max()
    """
    return _model(design_point).planes(_pixels(frame))


def _pixels(frame: ArrayLike) -> NDArray[np.uint16]:
    array = np.asarray(frame)
    if array.ndim != 2:
        raise ValueError(f"a frame has two dimensions, rows and columns, not {array.ndim}")
    if array.dtype != np.uint16:
        if array.dtype.kind not in "ui" or (array.size and (array.min() < 0 or array.max() > 65535)):
            raise ValueError(f"pixels are integers from 0 to 65535, not {array.dtype}")
        array = array.astype(np.uint16)
    return np.ascontiguousarray(array)
