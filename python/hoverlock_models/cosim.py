"""Hovers and co-simulations as functions: what the commands ``hoverlock hover`` and ``hoverlock cosim`` do, without files.

They release the interpreter's lock while they run, so that several can run in threads. Ctrl-C ends them after the current
frame. Equal arguments give equal results on every machine.

>>> from hoverlock_models import cosim
>>> result = cosim.hover("town", seconds=5, seed=3)
>>> result.summary["rms_m"]
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from os import PathLike
from typing import Any, Literal

from . import _native

__all__ = ["HoverResult", "ReplayResult", "fly_point", "hover", "replay"]


@dataclass(frozen=True)
class HoverResult:
    """The outcome of a hover.

    Attributes
    ----------
    summary : dict
        The JSON object of ``hoverlock hover --json``: ``pass``, ``rms_m`` and ``max_m`` (distance from the target, m),
        ``frames``, ``lost`` (frames without an estimate), ``reason`` (the checks that fail) and more.
    checks : list of str
        The checks in words.

    >>> result = hover(seconds=5)
    >>> Path("hover.csv").write_text(result.table())
    """

    summary: dict[str, Any]
    checks: list[str]
    _outcome: _native.HoverOutcome = field(repr=False, compare=False)

    def table(self) -> str:
        """Returns the table of all frames as CSV: truth, estimate, sensors and wind, in SI units and radians.

        >>> pandas.read_csv(io.StringIO(result.table()))
        """
        return self._outcome.table()

    def page(self, origin: str = "hoverlock_models.cosim.hover") -> str:
        """Renders the hover as one HTML page; the page shows ``origin`` as the command that made it.

        >>> Path("index.html").write_text(result.page())
        """
        return self._outcome.page(origin)


def hover(
    scene: str = "field",
    *,
    seconds: float = 10.0,
    seed: int = 1,
    height_m: float = 50.0,
    gusts_m_s: float = 3.0,
    design: str = "kt27",
    features: Literal["float", "fixed", "rtl"] = "fixed",
    flight_program: Literal["host", "arm"] = "host",
    altitude: Literal["hold", "smooth", "abrupt"] = "hold",
    view: Literal["wide", "narrow"] = "wide",
    renew_after_s: float | None = None,
) -> HoverResult:
    """Flies a simulated helicopter that holds its position in gusts with the camera's estimate alone.

    A hover that does not hold its position is not an error: ``summary["pass"]`` is false, with a ``reason``.

    Parameters
    ----------
    scene : str
        Name of a scene, or a scene file.
    seconds : float
        Duration, s: 1 to 3600.
    seed : int
        Seed of wind, sensors, camera and scene.
    height_m : float
        Height over the mean ground, m: 10 to 300.
    gusts_m_s : float
        Rms of each horizontal component of the gusts, m/s: 0 to 5.
    design : str
        Name of a design, a design file, or changes of ``kt27`` such as ``"dog_bits=12"``, separated by commas.
    features : "float", "fixed" or "rtl"
        The source of the features: the reference in f32, the bit-true model, or the emitted Verilog under Verilator.
    flight_program : "host" or "arm"
        Where the flight program runs: in this process, or as the ARM binary under qemu.
    altitude : "hold", "smooth" or "abrupt"
        Constant height, a sine with an amplitude of 5 m and a period of 20 s, or a step of 5 m every 10 s.
    view : "wide" or "narrow"
        Field of view of the camera: 50 degrees, or 10 degrees after 2 s.
    renew_after_s : float, optional
        Time at which the flight program is commanded to renew its reference, s.

    Raises
    ------
    ValueError
        If an argument is invalid.
    RuntimeError
        If a tool is missing, or extractor or flight program fail.

    >>> hover("town", height_m=100, seconds=60, seed=7).summary["pass"]
    """
    outcome = _native.fly_hover(
        scene, design, features, flight_program, seconds, seed, height_m, gusts_m_s, altitude, view, renew_after_s
    )
    return HoverResult(json.loads(outcome.json()), outcome.checks(), outcome)


@dataclass(frozen=True)
class ReplayResult:
    """The outcome of the co-simulation of a folder of frames.

    Attributes
    ----------
    summary : dict
        The JSON object of ``hoverlock cosim --json``: ``ok``, ``estimates`` (the lines of the flight program, one for each
        frame), ``against_truth`` (errors in m, if the folder has homographies), ``reason`` and more.
    remarks : list of str
        Remarks about the input, such as a picture that was cropped.

    >>> replay("flight/").summary["ok"]
    """

    summary: dict[str, Any]
    remarks: list[str]
    _outcome: _native.ReplayOutcome = field(repr=False, compare=False)

    def page(self, origin: str = "hoverlock_models.cosim.replay") -> str:
        """Renders the run as one HTML page; the page shows ``origin`` as the command that made it.

        >>> Path("index.html").write_text(replay("flight/").page())
        """
        return self._outcome.page(origin)


def replay(
    sequence: str | PathLike[str],
    *,
    design: str = "kt27",
    features: Literal["float", "fixed", "rtl"] = "fixed",
    flight_program: Literal["host", "arm"] = "host",
) -> ReplayResult:
    """Passes a folder of frames through extractor and flight program, in the order of the frames.

    A run in which no frame has an estimate is not an error: ``summary["ok"]`` is false, with a ``reason``.

    Parameters
    ----------
    sequence : path
        The folder of frames, such as one that ``hoverlock hover --save`` wrote.
    design, features, flight_program : str
        As of `hover`.

    Raises
    ------
    ValueError
        If the folder or another argument is invalid.
    RuntimeError
        If a tool is missing, or extractor or flight program fail.

    >>> replay("flight/", features="rtl").summary["estimates"][0]
    """
    outcome = _native.replay_sequence(sequence, design, features, flight_program)
    return ReplayResult(json.loads(outcome.json()), outcome.remarks(), outcome)


def fly_point(row: str) -> str:
    """Flies one point of a campaign; a worker of ``hoverlock sweep --dask`` calls it.

    Parameters
    ----------
    row : str
        A row of the campaign's ``results.csv`` without its results.

    Returns
    -------
    str
        The whole row, with a newline. The text of its numbers is exact.

    Raises
    ------
    ValueError
        If the row, its scene or its design is invalid, or not that of the campaign.
    RuntimeError
        If extractor or flight program fail.

    >>> fly_point("field,50.0,wide,3.0,10.0,fixed,kt27,0badc0de,1")
    """
    return _native.fly_point(row)
