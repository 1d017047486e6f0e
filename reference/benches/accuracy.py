"""Accuracy over simulated flights of this project, beside OpenCV's ORB, AKAZE, BRISK and SIFT (MAGSAC) and Lucas-Kanade (KLT).

Usage: python accuracy.py [--every N] [--flights N] [--peers orb,akaze,..] [--record COMMAND] FOLDER PICTURE..

The example `accuracy` renders the frames of flights over the pictures into FOLDER once. This program writes the result of
each method beside them once, lets the example score all results, as they are and refined on the frames, and prints the
tables and plots of `accuracy_report.py`. Each method gets the same frames, stretched to 8 bit between the percentiles 0.5
and 99.5, at most a thousand features (the strongest), the same matching (mutual best, at most 0.9 of the distance of the
second best, in both directions) and MAGSAC with 2 px; fewer than 8 inliers are no estimate. KLT follows the thousand best
corners through a pyramid, there and back.

The flight program runs in `hoverlock cosim`, behind the bit-true extractor, without samples of an IMU, with the calibration of its
camera and without one. The first frame is its reference, and the second comes twice, 2 s later; the last estimate counts. The metres
of `hoverlock match` are another such method. Both are run each time. Exit status 2 on bad usage.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable, NamedTuple

import accuracy_report
import cv2
import numpy as np

MAX_FEATURES, MAX_RATIO, INLIER_RADIUS_PX, MIN_INLIERS = 1000, 0.9, 2.0, 8
# KLT: quality and distance of the corners as in OpenCV's example; six levels reach a motion of 200 px. A track that returns
# further than MAX_RETURN_PX from its start is dropped.
CORNER_QUALITY, CORNER_SEPARATION_PX, WINDOW, TOP_LEVEL, MAX_RETURN_PX = 0.01, 10, (21, 21), 5, 0.5
# The camera of the flights has no errors. What the flight program knows of it is as good as a calibration with a chessboard.
CALIBRATION = "k1 = { value = 0.0, sigma = 0.001 }\nfocal = { value = 0.0, sigma = 0.001 }\nreadout_s = { value = 0.0, sigma = 0.0001 }\n"
DETECTORS = {
    "orb": lambda: cv2.ORB_create(MAX_FEATURES),
    "akaze": lambda: cv2.xfeatures2d.AKAZE_create(),
    "brisk": lambda: cv2.xfeatures2d.BRISK_create(),
    "sift": lambda: cv2.SIFT_create(MAX_FEATURES),
}


def build(package: str, name: str, *kind: str) -> str:
    """Builds a program of a package and returns the path of its executable."""
    command = ["cargo", "build", "--release", "--locked", "--package", package, *kind, name, "--message-format=json"]
    root = Path(__file__).resolve().parents[2]
    built = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, check=True, text=True)
    artefacts = (json.loads(line) for line in built.stdout.splitlines() if line.startswith("{"))
    return next(a["executable"] for a in artefacts if a.get("target", {}).get("name") == name and a["executable"])


class Command(NamedTuple):
    """A command that gives metres and no matches.

    `times_s` are those of its frames: the reference, and then the second picture once or more. `arguments` become its command
    line from the folder of the frames, `numbers` its displacement and covariance from what it prints.
    """

    times_s: tuple[float, ...]
    arguments: Callable[[Path], list]
    numbers: Callable[[dict], list[float]]


def numbers_of_match(result: dict) -> list[float]:
    return [*(result["displacement_m"] or ()), *(result["covariance_m2"] or ())]


def numbers_of_cosim(result: dict) -> list[float]:
    last = result["estimates"][-1]
    return [last["x_e_m"], last["y_e_m"], *last["covariance_m2"]] if "covariance_m2" in last else []


COMMANDS = {
    # After 2 s a reference is confirmed by one frame.
    "cosim": Command((0.0, 2.0, 2.067), lambda folder: [folder], numbers_of_cosim),
    "match": Command((0.0, 2.0), lambda folder: [*sorted(folder.glob("*.pgm")), "--telemetry", folder / "telemetry.csv",
                                               "--calibration", folder / "calibration.toml"], numbers_of_match),
}
# Command and calibration of each method that gives metres and no matches.
FLOWN = {"flight_program": ("cosim", CALIBRATION), "uncalibrated": ("cosim", ""),
         "match": ("match", CALIBRATION), "match_uncalibrated": ("match", "")}


def fly(program: str, folder: Path, name: str, method: str) -> None:
    """Passes the frames of a flight to the flight program or to `match`, and writes the last displacement for the example."""
    command, calibration = FLOWN[method]
    times_s, arguments, numbers = COMMANDS[command]
    header, *rows = (folder / f"{name}.telemetry.csv").read_text().split()
    with tempfile.TemporaryDirectory(dir=folder) as sequence:
        telemetry = ["time_s," + header]
        for number, time_s in enumerate(times_s):
            second = min(number, 1)
            os.link(folder / f"{name}.{('ref', 'cur')[second]}.pgm", Path(sequence, f"{number}.pgm"))
            telemetry.append(f"{time_s},{rows[second]}")
        Path(sequence, "telemetry.csv").write_text("\n".join(telemetry) + "\n")
        Path(sequence, "calibration.toml").write_text(calibration)
        start = time.perf_counter()
        # Status 1: there is no estimate.
        run = subprocess.run([program, command, "--json", *arguments(Path(sequence))], stdout=subprocess.PIPE, text=True)
        if run.returncode not in (0, 1):
            raise subprocess.CalledProcessError(run.returncode, run.args)
        seconds = time.perf_counter() - start
    found = " ".join(map(str, numbers(json.loads(run.stdout)))) or "none"
    part = folder / f"{name}.{method}.part"
    part.write_text(f"{1e3 * seconds:.3f}\n{found}\n")
    part.rename(folder / f"{name}.{method}.txt")


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
    """Returns the index pairs that are mutual best matches and pass the ratio test in both directions, the best first."""
    if a is None or b is None or len(a) < 2 or len(b) < 2:
        return []
    matcher = cv2.BFMatcher(norm)
    best = [{m.queryIdx: m for m, n in matcher.knnMatch(p, q, k=2) if m.distance <= MAX_RATIO * n.distance}
            for p, q in ((a, b), (b, a))]
    mutual = [m for i, m in best[0].items() if best[1].get(m.trainIdx) is not None and best[1][m.trainIdx].trainIdx == i]
    return [(m.queryIdx, m.trainIdx) for m in sorted(mutual, key=lambda m: m.distance)]


def motion(rows):
    """Returns the homography of matches `x y x' y'`, None if there is none, and the matches with an inlier flag."""
    homography, inliers = None, np.zeros(len(rows))
    if len(rows) >= 4:
        homography, mask = cv2.findHomography(rows[:, :2], rows[:, 2:], cv2.USAC_MAGSAC, INLIER_RADIUS_PX, maxIters=20000, confidence=0.9999)
        if homography is not None:
            inliers = mask.ravel()
    return homography if inliers.sum() >= MIN_INLIERS else None, np.column_stack([rows, inliers])


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
    return detect, time.perf_counter() - start, len(points), *motion(rows)


def by_tracking(reference, current):
    """Returns the same for corners followed by pyramidal Lucas-Kanade, with the check forward and backward."""
    start = time.perf_counter()
    corners = cv2.goodFeaturesToTrack(reference, MAX_FEATURES, CORNER_QUALITY, CORNER_SEPARATION_PX)
    detect = time.perf_counter() - start
    if corners is None:
        return detect, 0.0, 0, *motion(np.zeros((0, 4)))
    start = time.perf_counter()
    there, found, _ = cv2.calcOpticalFlowPyrLK(reference, current, corners, None, winSize=WINDOW, maxLevel=TOP_LEVEL)
    back, returned, _ = cv2.calcOpticalFlowPyrLK(current, reference, there, None, winSize=WINDOW, maxLevel=TOP_LEVEL)
    corners, there, back = (points.reshape(-1, 2).astype(float) for points in (corners, there, back))
    good = (found.ravel() == 1) & (returned.ravel() == 1) & (np.linalg.norm(back - corners, axis=1) < MAX_RETURN_PX)
    return detect, time.perf_counter() - start, len(corners), *motion(np.column_stack([corners, there])[good])


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
    parser.add_argument("folder", type=Path)
    parser.add_argument("pictures", type=Path, nargs="+", metavar="PICTURE", help="ground to fly over, at least 640 x 480 px")
    parser.add_argument("--every", type=int, default=1, help="use only every N-th case of a picture")
    parser.add_argument("--flights", type=int, default=1, help="flights of each picture and case")
    parser.add_argument("--peers", default="orb,akaze,brisk,sift,klt")
    parser.add_argument("--record", metavar="COMMAND", help="store the numbers over held-back ground in docs/results.json, as those of COMMAND")
    arguments = parser.parse_args()
    for picture in arguments.pictures:
        if not picture.is_file():
            print(f"{picture}: no such picture; run `make setup`, or name others", file=sys.stderr)
            return 2
    cv2.setNumThreads(1)
    cv2.setRNGSeed(1)
    program = build("hoverlock-reference", "accuracy", "--example")
    flown = build("hoverlock-cli", "hoverlock", "--bin")
    common = [str(v) for v in (arguments.folder, arguments.every, arguments.flights, *arguments.pictures)]
    simulated = subprocess.run([program, "simulate", *common], stdout=subprocess.PIPE, text=True)
    if simulated.returncode:
        return simulated.returncode
    for name in simulated.stdout.split():
        for method in FLOWN:
            fly(flown, arguments.folder, name, method)
        missing = [m for m in arguments.peers.split(",") if m and not (arguments.folder / f"{name}.{m}.txt").exists()]
        if not missing:
            continue
        frames = [eight_bit(arguments.folder / f"{name}.{which}.pgm") for which in ("ref", "cur")]
        for method in missing:
            found = by_tracking(*frames) if method == "klt" else by_features(method, *frames)
            write(arguments.folder / f"{name}.{method}.txt", *found)
    status = subprocess.run([program, "score", *common]).returncode
    if status == 0:
        accuracy_report.write(arguments.folder, arguments.record)
    return status


if __name__ == "__main__":
    sys.exit(main())
