"""Accuracy over simulated flights, side by side with OpenCV's ORB, AKAZE, BRISK, SIFT (MAGSAC) and phase correlation.

Usage: python accuracy.py [--every N] [--flights N] [--peers orb,akaze,..] [--record] TEXTURES FOLDER

The example `accuracy` renders the frames into FOLDER once. This program writes the result of each method beside them
once, lets the example score all results, and prints the tables and plots of `accuracy_report.py`. Each method gets the
same frames, stretched to 8 bit between the percentiles 0.5 and 99.5, at most a thousand features (the strongest), the
same matching (mutual best, at most 0.9 of the distance of the second best, in both directions) and MAGSAC with 2 px;
fewer than 8 inliers are no estimate. Exit status 2 on bad usage.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import accuracy_report
import cv2
import numpy as np

MAX_FEATURES, MAX_RATIO, INLIER_RADIUS_PX, MIN_INLIERS = 1000, 0.9, 2.0, 8
DETECTORS = {
    "orb": lambda: cv2.ORB_create(MAX_FEATURES),
    "akaze": lambda: cv2.xfeatures2d.AKAZE_create(),
    "brisk": lambda: cv2.xfeatures2d.BRISK_create(),
    "sift": lambda: cv2.SIFT_create(MAX_FEATURES),
}


def example() -> str:
    """Builds the example and returns the path of its executable."""
    command = ["cargo", "build", "--release", "--locked", "--example", "accuracy", "--message-format=json"]
    root = Path(__file__).resolve().parent.parent
    built = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True, text=True)
    artefacts = (json.loads(line) for line in built.stdout.splitlines() if line.startswith("{"))
    return next(a["executable"] for a in artefacts if a.get("target", {}).get("name") == "accuracy" and a["executable"])


def eight_bit(path: Path):
    """Returns the frame stretched to 8 bit, as the detectors need it."""
    frame = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    low, high = np.percentile(frame, [0.5, 99.5])
    return np.clip((frame - low) * (255.0 / max(high - low, 1.0)), 0, 255).astype(np.uint8)


def strongest(detector, frame):
    """Returns at most MAX_FEATURES points with their descriptors, the strongest first."""
    points, descriptors = detector.detectAndCompute(frame, None)
    if descriptors is None or len(points) <= MAX_FEATURES:
        return points, descriptors
    order = np.argsort([-p.response for p in points], kind="stable")[:MAX_FEATURES]
    return [points[i] for i in order], descriptors[order]


def mutual_matches(norm, a, b):
    """Returns the index pairs that are mutual best matches and pass the ratio test in both directions."""
    if a is None or b is None or len(a) < 2 or len(b) < 2:
        return []
    matcher = cv2.BFMatcher(norm)
    best = [{m.queryIdx: m for m, n in matcher.knnMatch(p, q, k=2) if m.distance <= MAX_RATIO * n.distance}
            for p, q in ((a, b), (b, a))]
    return [(i, m.trainIdx) for i, m in best[0].items() if best[1].get(m.trainIdx) is not None and best[1][m.trainIdx].trainIdx == i]


def by_features(name, reference, current):
    """Returns seconds of detection and matching, number of features, homography, and matches with an inlier flag."""
    detector = DETECTORS[name]()
    start = time.perf_counter()
    points, descriptors = strongest(detector, reference)
    detect = time.perf_counter() - start
    others, other_descriptors = strongest(detector, current)
    start = time.perf_counter()
    matches = mutual_matches(cv2.NORM_L2 if name == "sift" else cv2.NORM_HAMMING, descriptors, other_descriptors)
    rows = np.array([points[i].pt + others[j].pt for i, j in matches], float).reshape(-1, 4)
    homography, inliers = None, np.zeros(len(rows))
    if len(rows) >= 4:
        homography, mask = cv2.findHomography(rows[:, :2], rows[:, 2:], cv2.USAC_MAGSAC, INLIER_RADIUS_PX, maxIters=20000, confidence=0.9999)
        if homography is not None:
            inliers = mask.ravel()
    if inliers.sum() < MIN_INLIERS:
        homography = None
    return detect, time.perf_counter() - start, len(points), homography, np.column_stack([rows, inliers])


def by_phase(reference, current):
    """Returns the same for phase correlation, which has no features."""
    start = time.perf_counter()
    window = cv2.createHanningWindow(reference.shape[::-1], cv2.CV_32F)
    (dx, dy), _ = cv2.phaseCorrelate(reference.astype(np.float32), current.astype(np.float32), window)
    return 0.0, time.perf_counter() - start, 0, np.array([[1, 0, dx], [0, 1, dy], [0, 0, 1.0]]), np.zeros((0, 5))


def write(path: Path, detect, match, features, homography, rows):
    """Writes a result file that the example reads."""
    lines = [f"{1e3 * detect:.3f} {1e3 * match:.3f} {features}"]
    lines.append("none" if homography is None else " ".join(f"{v:.12g}" for v in homography.ravel()))
    lines += [" ".join(f"{v:.5f}" for v in row) for row in rows]
    part = path.with_suffix(".part")
    part.write_text("\n".join(lines) + "\n")
    part.rename(path)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("textures", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, help="use only every N-th flight")
    parser.add_argument("--flights", type=int, default=1, help="flights of each texture and condition, for hoverlock")
    parser.add_argument("--peers", default="orb,akaze,brisk,sift,phase")
    parser.add_argument("--record", action="store_true", help="store the numbers over held-back ground in docs/results.json")
    arguments = parser.parse_args()
    if not arguments.textures.is_dir():
        print(f"{arguments.textures}: no folder of textures; set HOVERLOCK_DATA to the folder of pictures", file=sys.stderr)
        return 2
    cv2.setNumThreads(1)
    cv2.setRNGSeed(1)
    program = example()
    common = [str(arguments.textures), str(arguments.folder), str(arguments.every)]
    simulated = subprocess.run([program, "simulate", *common], check=True, stdout=subprocess.PIPE, text=True)
    for name in simulated.stdout.split():
        missing = [m for m in arguments.peers.split(",") if m and not (arguments.folder / f"{name}.{m}.txt").exists()]
        if not missing:
            continue
        frames = [eight_bit(arguments.folder / f"{name}.{which}.pgm") for which in ("ref", "cur")]
        for method in missing:
            found = by_phase(*frames) if method == "phase" else by_features(method, *frames)
            write(arguments.folder / f"{name}.{method}.txt", *found)
    status = subprocess.run([program, "score", *common, str(arguments.flights)]).returncode
    if status == 0:
        command = f"make bench-accuracy EVERY={arguments.every} FLIGHTS={arguments.flights}"
        accuracy_report.write(arguments.folder, command if arguments.record else None)
    return status


if __name__ == "__main__":
    sys.exit(main())
