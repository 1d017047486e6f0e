"""Hoverlock's own part of a bench: the bit-true model, the feature records and the coefficients, on numpy arrays.

>>> import hoverlock_models as models
>>> assert np.array_equal(received, models.features(frame, thresholds))

The bench itself is the package `hoverlock`, which knows nothing of this algorithm.
"""

from __future__ import annotations

from .bit_true import FEATURE, FEATURE_OF_THREE_PAIRS, Planes, design_point, emission, features, planes, records
from .smoothers import Coefficients, coefficients, look_ahead

__all__ = [
    "FEATURE", "FEATURE_OF_THREE_PAIRS", "Coefficients", "Planes", "coefficients", "design_point", "emission", "features",
    "look_ahead", "planes", "records",
]  # fmt: skip
