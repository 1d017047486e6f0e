"""The coefficients of the recursive smoothers."""

from __future__ import annotations

from dataclasses import dataclass

from ._native import lerp_coefficients, look_ahead_of

__all__ = ["Coefficients", "coefficients", "look_ahead"]


@dataclass(frozen=True)
class Coefficients:
    """The coefficients of one smoother.

    Attributes
    ----------
    sigma : float
        Standard deviation of the smoother, in pixels.
    frac_bits : int
        Fractional bits of the coefficients: one LSB of ``g`` and ``g_j`` is 2^-frac_bits.
    a : float
        The pole of the recursion.
    g : int
        The coefficient of the recursion, as a raw integer.
    g_j : tuple of int
        The coefficients of the look-ahead stages, as raw integers.
    saturated : tuple of int
        The stages whose coefficient rounds to 1 and is limited to 1 - 2^-frac_bits.

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

    Parameters
    ----------
    sigma : float
        Standard deviation in pixels.
    look_ahead : int
        Number of look-ahead stages; stage j combines samples that are 2^j apart.
    frac_bits : int
        Fractional bits of the coefficients.

    Raises
    ------
    ValueError
        If no smoother of that sigma, look-ahead and word length exists.

    >>> coefficients(2.0, 5).g
    24536
    """
    a, g, g_j, saturated = lerp_coefficients(sigma, look_ahead, frac_bits)
    return Coefficients(sigma, frac_bits, a, g, tuple(g_j), tuple(saturated))


def look_ahead(a: float, error: float) -> int:
    """Returns the smallest number of look-ahead stages for an error.

    Parameters
    ----------
    a : float
        The pole of the recursion, between 0 and 1.
    error : float
        Largest fraction of the infinite sum that may be left out, between 0 and 1.

    Raises
    ------
    ValueError
        If ``error`` is not between 0 and 1, or so small that no look-ahead reaches it.

    >>> look_ahead(0.5, 0.5 ** 8)
    3
    """
    return look_ahead_of(a, error)
