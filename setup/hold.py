#!/usr/bin/env python3
"""Summarises the flights of `docs/hold.csv` as entries `hold.SCENE.HEIGHT.FEATURES` of `docs/results.json`, `.._narrow` in the narrow view;
`hold.all` is over several scenes.

The table is a `results.csv` of `hoverlock sweep --seeds N --seconds 60 --view wide,narrow`. Run this after it has grown, then `make results`.
"""

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import results

TABLE = results.ROOT / "docs/hold.csv"
COMMAND = "hoverlock sweep --seeds N --seconds 60 --view wide,narrow, then setup/hold.py"
FLIGHTS = {
    "figure": "distance of a simulated helicopter from its target, rms of each flight of 60 s",
    "unit": "cm",
    "conditions": "gusts of 3 m/s rms; lowest and highest of the flights, and the rms over all",
    "command": COMMAND,
}
IMU_ONLY = {
    "figure": "the same flights with the IMU alone, rms of each flight",
    "unit": "m",
    "conditions": "50 m, gusts of 3 m/s rms",
    "command": COMMAND,
}


def flights(table: Path = TABLE) -> list[dict]:
    with open(table, newline="") as file:
        return list(csv.DictReader(file))


def summaries(rows: list[dict]) -> dict[str, dict]:
    """Returns the number of flights, how many passed, and their rms from the target (cm), for each scene, height, kind of features and
    view, which a key names if it is not the wide one."""
    groups = defaultdict(list)
    for row in rows:
        scene, height = row["scene"].replace("-", "_"), float(row["height_m"])
        view = row.get("view", "wide")
        for of in (scene, "all"):
            groups[f"hold.{of}.{height:.0f}m.{row['features']}" + ("" if view == "wide" else f"_{view}")].append(row)
    found = {}
    for key, group in groups.items():
        if key.startswith("hold.all.") and len({row["scene"] for row in group}) == 1:
            continue
        rms = [100 * float(row["rms_m"]) for row in group]
        found[key] = {"flights": len(group), "passed": sum(row["pass"] == "true" for row in group), "min": round(min(rms), 1),
                      "max": round(max(rms), 1), "rms": round(math.sqrt(sum(v * v for v in rms) / len(rms)), 2)}
    return found


def imu_only(rows: list[dict]) -> dict[str, int]:
    """Returns the smallest and the largest rms of the flights at 50 m without vision, m."""
    rms = [float(row["imu_only_rms_m"]) for row in rows if float(row["height_m"]) == 50]
    return {"min": round(min(rms)), "max": round(max(rms))}


if __name__ == "__main__":
    rows = flights()
    results.record(summaries(rows), commit=results.commits(rows), **FLIGHTS)
    results.record({"hold.imu_only": imu_only(rows)}, commit=results.commits(rows), **IMU_ONLY)
