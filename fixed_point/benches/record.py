#!/usr/bin/env python3
"""Stores the last speeds of `cargo bench -p hoverlock-fixed-point --bench bit_true` in `docs/results.json`, from criterion's estimates."""

import json
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "setup"))
import results  # noqa: E402

PIXELS = 1024 * 768
FOLDER = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "criterion/bit_true"
BENCHES = {"avx2": "best instructions", "portable": "portable"}


def megapixels_per_second(name: str) -> int:
    """Returns the speed at the median time of a bench; criterion states times in nanoseconds."""
    estimates = json.loads((FOLDER / name.replace(" ", "_") / "new/estimates.json").read_text())
    return round(PIXELS / estimates["median"]["point_estimate"] * 1e3)


if __name__ == "__main__":
    results.record({f"bit_true.throughput.{key}": megapixels_per_second(name) for key, name in BENCHES.items()}, command="make bench")
