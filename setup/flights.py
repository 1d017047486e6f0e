#!/usr/bin/env python3
"""Summarises the random flights of `docs/flights.csv` as entries `flights.random.DURATION` of `docs/results.json`.

The table is that of `hoverlock sweep --random N --seed S --table docs/flights.csv`. Run this after it has grown, then `make results`.
"""

import argparse
import csv
import math
import statistics
import sys
from collections import defaultdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import results

TABLE = results.ROOT / "docs/flights.csv"
# Ingredients with a number in every flight; ingredients of which each value is one.
IN_EVERY_FLIGHT = ("height", "gusts", "sun")
NAMED_BY_VALUE = ("ground", "climb")
FIGURE = {
    "figure": "random flights; an estimate is misleading if its error exceeds its protection level",
    "unit": "flights, estimates, %, cm",
    "conditions": "features fixed; ground, weather, camera errors and faults drawn from a seed; availability in frames that show the ground",
    "command": "hoverlock sweep --random N --seed S --table docs/flights.csv, then setup/flights.py",
}


def flights(table: Path = TABLE) -> list[dict]:
    with open(table, newline="") as file:
        return list(csv.DictReader(file))


def summaries(rows: list[dict]) -> dict[str, dict]:
    """Returns the totals for each duration of a flight."""
    durations = sorted({float(row["seconds"]) for row in rows})
    return {f"flights.random.{seconds:.0f}s": summary([row for row in rows if float(row["seconds"]) == seconds]) for seconds in durations}


def nees_by_ingredient(rows: list[dict]) -> dict[str, float]:
    """Returns the mean NEES of the flights that have an ingredient, for each that flights can lack."""
    nees = defaultdict(list)
    for row in rows:
        for ingredient in row["ingredients"].split():
            kind, value = ingredient.split("=")
            if kind not in IN_EVERY_FLIGHT:
                nees[f"{kind} {value}" if kind in NAMED_BY_VALUE else kind].append(float(row["nees"]))
    return {ingredient: statistics.fmean(values) for ingredient, values in nees.items()}


def summary(rows: list[dict]) -> dict:
    """Returns totals over rows. NEES and error are those of the flights with an estimate."""
    total = lambda key: sum(int(row[key]) for row in rows)
    estimates = sum(int(cell.split(":")[2]) for row in rows for cell in row["cells"].split())
    answered = [row for row in rows if row["nees"]]
    nees = [float(row["nees"]) for row in answered]
    ingredients = nees_by_ingredient(answered).values()
    errors = [float(row["error_rms_m"]) for row in answered]
    return {
        "flights": len(rows),
        "misleading_flights": sum(int(row["misleading"]) > 0 for row in rows),
        "estimates": estimates,
        "misleading": total("misleading"),
        "late": total("late"),
        "without_estimate": len(rows) - len(answered),
        "availability": round(100 * total("answered") / total("in_view"), 1),
        "nees_median": round(statistics.median(nees), 2),
        "nees_mean": round(statistics.fmean(nees), 1),
        "nees_ingredient_min": round(min(ingredients), 1),
        "nees_ingredient_max": round(max(ingredients), 1),
        "error_median": round(100 * statistics.median(errors), 1),
        "error_rms": round(100 * math.sqrt(statistics.fmean(error * error for error in errors)), 1),
        "worst_ratio": round(max(float(row["worst_ratio"]) for row in answered), 1),
    }


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    rows = flights()
    results.record(summaries(rows), commit=results.commits(rows), **FIGURE)
