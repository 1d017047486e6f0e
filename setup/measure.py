#!/usr/bin/env python3
"""Measures the numbers that the command prints as JSON, and stores them in `docs/results.json`: `make measure`.

Usage: setup/measure.py COMMAND PICTURE, with the path of `hoverlock` and of `aero1.jpg`.

The simulation of one picture, and the estimate of each shipped design.
"""

import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import results


def printed(*command: str) -> dict:
    """Returns the JSON object that a command prints."""
    return json.loads(subprocess.run([*command, "--json"], stdout=subprocess.PIPE, check=True, text=True).stdout)


def of_simulation(out: dict) -> dict[str, float]:
    """Returns the values of `hoverlock sim --json` by their keys."""
    names = {"pixels": "pixels", "cycles": "cycles", "cycles_per_pixel": "cycles_per_pixel", "samples": "samples", "features": "features",
             "mismatches": "mismatches", "lines_to_sample": "latency_lines", "lines_to_record": "feature_latency_lines"}
    return {f"sim.aero1.{key}": out[name] for key, name in names.items()} | {"sim.speed": round(out["cycles_per_second"], -4)}


def of_estimate(design: str, out: dict) -> dict[str, float]:
    """Returns the values of `hoverlock rtl estimate --json` by their keys; the default design has more of them."""
    names = {"alm": "alm", "m10k": "m10k", "dsp": "dsp"}
    values = {}
    if design == "kt27":
        names |= {"mul18": "mul18", "mlab": "mlab", "registers": "registers", "levels": "logic_levels", "cell_delay_ps": "cell_delay_ps",
                  "target_mhz": "target_mhz"}
        used = out["devices"][0]["used_percent"]
        values = {f"{name}_percent": round(percent, 1) for name, percent in zip(("alm", "m10k", "dsp"), used)}
        values["lerp_delay_ps"] = next(module["cell_delay_ps"] for module in out["modules"] if module["name"] == "lerp")
    return {f"rtl.estimate.{design}.{key}": value for key, value in ({key: out[name] for key, name in names.items()} | values).items()}


def main(command: str, picture: str) -> None:
    results.record(of_simulation(printed(command, "sim", picture)))
    for design in ("kt27", "hd1080", "small", "three_scales"):
        results.record(of_estimate(design, printed(command, "rtl", "estimate", "--design", design)))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: setup/measure.py COMMAND PICTURE")
    main(*sys.argv[1:])
