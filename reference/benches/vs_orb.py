"""Float features of one 1024x768 frame against OpenCV's ORB, one thread each, alternately on one core.

Usage: python vs_orb.py [--rounds 7] [--runs 10] [--max-ratio 1.0] [--record] IMAGE..

Both get the same frame: the 1024x768 pixels in the middle of the picture, in 8 bit; a smaller picture is mirrored at its
borders until it fills the frame. Both are asked for a thousand described features. Reading the picture is not timed. A
round is `--runs` runs of Hoverlock, then as many of ORB, so that other load of the machine affects both. Prints the medians
and their ratio per picture. Exit status 1 if the ratio is above the limit or Hoverlock returns fewer than a thousand
features, 2 on bad usage.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "setup"))
import results  # noqa: E402

WIDTH, HEIGHT, FEATURES = 1024, 768, 1000


def example() -> str:
    """Builds the Rust example and returns the path of its executable."""
    command = ["cargo", "build", "--release", "--example", "float_features", "--message-format=json"]
    root = Path(__file__).resolve().parent.parent
    built = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True, text=True)
    artefacts = (json.loads(line) for line in built.stdout.splitlines() if line.startswith("{"))
    return next(a["executable"] for a in artefacts if a.get("target", {}).get("name") == "float_features" and a["executable"])


def refuse(reason: str):
    print(reason, file=sys.stderr)
    sys.exit(2)


def frame_of(path: str):
    """Returns the 8-bit frame that both extractors get."""
    picture = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    if picture is None:
        refuse(f"{path}: not a picture OpenCV can read")
    while picture.shape[0] < HEIGHT or picture.shape[1] < WIDTH:
        height, width = picture.shape
        if min(height, width) < 64:
            refuse(f"{path}: {width}x{height} is too small to be mirrored to {WIDTH}x{HEIGHT}")
        picture = cv2.copyMakeBorder(picture, 0, height - 1, 0, width - 1, cv2.BORDER_REFLECT_101)
    x, y = (picture.shape[1] - WIDTH) // 2, (picture.shape[0] - HEIGHT) // 2
    return picture[y : y + HEIGHT, x : x + WIDTH].copy()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("images", nargs="+", metavar="IMAGE")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--max-ratio", type=float, default=1.0)
    parser.add_argument("--record", action="store_true", help="store the ratios in docs/results.json")
    arguments = parser.parse_args()

    frames = [(path, frame_of(path)) for path in arguments.images]
    program = example()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # the Rust example inherits it
    cv2.setNumThreads(1)
    orb = cv2.ORB_create(FEATURES)

    passed, ratios, low_texture = True, [], {}
    print(f"{'picture':<28} {'hoverlock':>10} {'ORB':>10} {'ratio':>6}   features (hoverlock, ORB)")
    for path, frame in frames:
        hoverlock, orb_seconds = [], []
        with tempfile.TemporaryDirectory() as folder:
            png = str(Path(folder) / "frame.png")
            cv2.imwrite(png, frame)
            for _ in range(arguments.rounds):
                run = subprocess.run([program, png, str(arguments.runs)], stdout=subprocess.PIPE, check=True)
                result = json.loads(run.stdout)
                hoverlock += result["seconds"]
                keypoints, _ = orb.detectAndCompute(frame, None)  # the first run sizes the buffers, as in hoverlock
                for _ in range(arguments.runs):
                    start = time.perf_counter()
                    orb.detectAndCompute(frame, None)
                    orb_seconds.append(time.perf_counter() - start)
        a, b = statistics.median(hoverlock), statistics.median(orb_seconds)
        good = a <= arguments.max_ratio * b and result["features"] >= FEATURES
        passed &= good
        if len(keypoints) < FEATURES:
            low_texture["features.against_orb.low_texture"] = round(a / b, 2)
        else:
            ratios.append(round(a / b, 2))
        counts = f"{result['features']}, {len(keypoints)}"
        print(f"{Path(path).name:<28} {a * 1e3:>7.2f} ms {b * 1e3:>7.2f} ms {a / b:>6.2f}   {counts}{'' if good else '  FAILED'}")
    if arguments.record and ratios:
        values = {"features.against_orb.min": min(ratios), "features.against_orb.max": max(ratios)}
        results.record(values | low_texture, command="make bench", conditions=f"by turns in one run; {len(frames)} pictures; low texture is "
                       f"where ORB finds fewer than {FEATURES}; smaller pictures are mirrored to fill the frame")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
