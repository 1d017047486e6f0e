"""Tables (Markdown) and plots (SVG) of the scores of `accuracy.py`. The plots show the held-back ground."""

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path
from statistics import mean, median

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "setup"))
import results  # noqa: E402

# Methods by their names in the scores, in the documents and in `docs/results.json`.
METHODS = {"flight_program": "Flight_program", "uncalibrated": "Uncalibrated", "match": "Match", "match_uncalibrated": "Match_uncalibrated",
           "hoverlock": "Hoverlock", "orb": "ORB", "akaze": "AKAZE", "brisk": "BRISK", "sift": "SIFT", "klt": "KLT"}
# Those that give no matches, with their lines in the table.
FLOWN = {"flight_program": "**flight program**", "uncalibrated": "**flight program**, camera not calibrated",
         "match": "`match`", "match_uncalibrated": "`match`, camera not calibrated"}
# The methods whose covariance is judged, with the beginnings of their names in `docs/results.json`.
OURS = {"match": "", "flight_program": "flight_program_"}
# Columns of the pose in the table, with the condition of each.
POSES = {"wide": "nominal", "hover": "hover", "narrow": "narrow", "relief": "relief"}
COLOURS = ["#111111", "#888888", "#0e6655", "#a2d9ce", "#c0392b", "#2471a3", "#1e8449", "#b9770e", "#7d3c98", "#5d6d7e"]
# Largest error at the centre of the frame of a correct motion, px.
MAX_CENTRE_ERROR_PX = 2.0


def rms(values):
    """Returns the root mean square, NaN for an empty list."""
    return math.sqrt(mean(v * v for v in values)) if values else math.nan


def average(values):
    """Returns the mean, NaN for an empty list."""
    return mean(values) if values else math.nan


def scores(folder: Path, tuning: bool) -> list[dict]:
    """Reads the flights over the ground used for tuning, or over the held-back half."""
    with open(folder / "scores.csv", newline="") as file:
        return [row for row in csv.DictReader(file) if row["tuning"] == str(int(tuning))]


def numbers(rows, name):
    """Returns the numbers of a column, without empty cells."""
    return [float(row[name]) for row in rows if row[name] not in ("", "NaN")]


def of_method(rows, method, refined: bool):
    """Returns the flights of a method, as it is or refined on the frames."""
    return [row for row in rows if row["method"] == method and row["refined"] == str(int(refined))]


def summary(rows, method, refined: bool) -> dict[str, float]:
    """Returns the numbers of a method's line in the table by their names; NaN where there is no value."""
    of = of_method(rows, method, refined)
    at = lambda condition: [row for row in of if row["condition"] == condition]
    found = {"first": round(average(numbers(of, "first")), 3), "final": round(average(numbers(of, "last")), 3),
             "localisation": round(average(numbers(at("nominal"), "localisation")), 3),
             "centre": round(rms(numbers(at("nominal"), "centre")), 4)}
    found |= {name: round(100 * rms(numbers(at(condition), "pose")), 1) for name, condition in POSES.items()}
    return found | {"no_pose": sum(row["pose"] == "" for row in of)}


def consistency(rows) -> str:
    """Returns a table of the NEES of the displacement of `match` and of the flight program, by condition.

    It is 2 for a correct covariance, within 4 / sqrt(flights) by chance. `outside` counts the errors beyond three
    estimated standard errors.
    """
    lines = ["| condition | flights | match: pose, cm | NEES | outside | no pose | flight program: pose, cm | NEES | outside | no pose |",
             "|---|" + "---|" * 9]
    for condition in dict.fromkeys(row["condition"] for row in rows):
        cells = []
        for method in OURS:
            at = [row for row in of_method(rows, method, True) if row["condition"] == condition]
            nees = numbers(at, "nees")
            cells += [f"{100 * rms(numbers(at, 'pose')):.1f}", f"{average(nees):.2f}", str(sum(v > 9 for v in nees)), str(len(at) - len(nees))]
        lines.append(f"| {condition} | {len(at)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def markdown(rows) -> str:
    """Returns a table with one line per method, as it is and refined; `-` means no value."""
    lines = ["| method | first matches right | last | localisation, px | centre, px | pose wide, cm | hover | narrow | relief "
             "| no pose | features, ms | matching, ms |", "|---|" + "---|" * 11]
    forms = dict.fromkeys(POSES, ".1f") | {"first": ".3f", "final": ".3f", "localisation": ".3f", "centre": ".4f"}
    for method, name in METHODS.items():
        for refined in (False, True):
            of = of_method(rows, method, refined)
            if not of:
                continue
            found = summary(rows, method, refined)
            cells = ["-" if math.isnan(found[key]) else format(found[key], forms[key])
                     for key in ("first", "final", "localisation", "centre", *POSES)]
            times = [format(median(ms), ".0f") if (ms := numbers(of, key)) else "-" for key in ("detect", "match")]
            label = FLOWN.get(method) or (f"{name}, refined" if refined else name)
            lines.append(f"| {label} | " + " | ".join(cells) + f" | {found['no_pose']} of {len(of)} | " + " | ".join(times) + " |")
    return "\n".join(lines)


def failures(rows) -> str:
    """Returns a table of the flights without a motion or with an error above MAX_CENTRE_ERROR_PX at the centre."""
    lines = [f"| method | no motion | centre off by more than {MAX_CENTRE_ERROR_PX:g} px | flights |", "|---|---|---|---|"]
    for method, name in METHODS.items():
        of = of_method(rows, method, False)
        if of:
            centres = numbers(of, "centre")
            lines.append(f"| {name} | {len(of) - len(centres)} | {sum(c > MAX_CENTRE_ERROR_PX for c in centres)} | {len(of)} |")
    return "\n".join(lines)


def values(rows) -> dict[str, dict[str, float]]:
    """Returns the numbers of both tables, named values of two entries of `docs/results.json`."""
    methods = {"flights": len(of_method(rows, "hoverlock", False))}
    for method, name in METHODS.items():
        for refined in (False, True):
            prefix = f"{name}.{'refined_' if refined and method not in FLOWN else ''}"
            if of_method(rows, method, refined):
                found = summary(rows, method, refined)
                methods |= {prefix + key: value for key, value in found.items() if not math.isnan(value)}
    covariance = {}
    for condition in dict.fromkeys(row["condition"] for row in rows):
        key = condition.replace(" ", "_").replace(".", "")
        for method, prefix in OURS.items():
            at = [row for row in of_method(rows, method, True) if row["condition"] == condition]
            nees = numbers(at, "nees")
            covariance |= {f"{key}.{prefix}pose": round(100 * rms(numbers(at, "pose")), 1),
                           f"{key}.{prefix}nees": round(average(nees), 2), f"{key}.{prefix}outside": sum(v > 9 for v in nees),
                           f"{key}.{prefix}no_pose": len(at) - len(nees)}
        covariance[f"{key}.flights"] = len(at)
    for method, prefix in OURS.items():
        nees = numbers(of_method(rows, method, True), "nees")
        covariance |= {f"all.{prefix}nees": round(average(nees), 2), f"all.{prefix}outside": sum(v > 9 for v in nees)}
    covariance["all.flights"] = len(of_method(rows, "match", True))
    return {"accuracy.methods": methods, "accuracy.covariance": covariance}


def text(x, y, words, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{words}</text>'


def frame(width, height, body) -> str:
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="12"><rect width="{width}" height="{height}" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n")


def pose_plot(rows) -> str:
    """Plots the root mean square error of the displacement by condition; all methods share refinement and pose fit."""
    conditions = list(dict.fromkeys(row["condition"] for row in rows))
    lines = [*((method, True) for method in FLOWN), ("hoverlock", False), *((method, True) for method in METHODS if method not in FLOWN)]
    left, right, top, bottom = 60, 880, 40, 330
    low, high = -2.3, 0.5
    y = lambda v: bottom - (math.log10(v) - low) / (high - low) * (bottom - top)
    x = lambda i: left + (i + 0.5) * (right - left) / len(conditions)
    body = [text(470, 20, "Error of the displacement, rms of the flights over held-back ground, m; rings: without refinement")]
    for v in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2):
        body += [f'<path d="M{left} {y(v):.1f}H{right}" stroke="#ddd"/>', text(left - 6, y(v) + 4, f"{v:g}", "end")]
    colour = dict(zip(METHODS, COLOURS))
    for i, condition in enumerate(conditions):
        body.append(text(x(i), bottom + 18, condition.replace("narrow noisy", "nar. noisy").replace("combined", "combin.")))
        for m, (method, refined) in enumerate(lines):
            values = numbers([row for row in of_method(rows, method, refined) if row["condition"] == condition], "pose")
            if values:
                v = min(max(rms(values), 10**low), 10**high)
                fill = colour[method] if refined else "white"
                body.append(f'<circle cx="{x(i) + 5.5 * (m - len(METHODS) / 2):.1f}" cy="{y(v):.1f}" r="{5 if method in OURS else 3.5}" '
                            f'fill="{fill}" stroke="{colour[method]}" stroke-width="2"/>')
    for m, (method, name) in enumerate(METHODS.items()):
        column, row = m % 5, m // 5
        body += [f'<circle cx="{40 + 172 * column}" cy="{bottom + 42 + 20 * row}" r="5" fill="{colour[method]}"/>',
                 text(50 + 172 * column, bottom + 46 + 20 * row, name.replace("_", " "), "start")]
    return frame(900, 410, body)


def reliability_plot(rows) -> str:
    """Plots the fraction of the flights whose error is within the ellipse of a given probability."""
    probabilities = sorted(1 - math.exp(-v / 2) for v in numbers(of_method(rows, "match", True), "nees"))
    left, top, side = 60, 40, 320
    place = lambda p, q: f"{left + side * p:.1f} {top + side * (1 - q):.1f}"
    body = [text(220, 20, f"Reliability of the covariance, {len(probabilities)} flights")]
    body.append(f'<rect x="{left}" y="{top}" width="{side}" height="{side}" fill="none" stroke="#999"/>')
    for p in (0, 0.2, 0.4, 0.6, 0.8, 1):
        body += [text(left + side * p, top + side + 18, f"{p:g}"), text(left - 6, top + side * (1 - p) + 4, f"{p:g}", "end")]
    body.append(f'<path d="M{place(0, 0)}L{place(1, 1)}" stroke="#999" stroke-dasharray="4 4"/>')
    steps = [place(p, (i + 1) / len(probabilities)) for i, p in enumerate(probabilities)]
    body.append(f'<path d="M{place(0, 0)}L{"L".join(steps)}" fill="none" stroke="{COLOURS[1]}" stroke-width="2"/>')
    body.append(text(left + side / 2, top + side + 38, "probability of the ellipse"))
    body.append(text(0, 0, "fraction of the errors within it", extra=f'transform="translate(16 {top + side / 2}) rotate(-90)"'))
    return frame(420, 410, body)


def write(folder: Path, record: str | None = None) -> None:
    """Prints the tables of both halves and writes `accuracy.svg` and `reliability.svg` into the folder.

    `record` is the command with which the numbers over held-back ground are stored in `docs/results.json`, `None` if they are not.
    """
    for half, tuning in (("Ground used for tuning", True), ("Held-back ground", False)):
        rows = scores(folder, tuning)
        if rows:
            print(f"\n## {half}\n\n" + "\n\n".join((markdown(rows), failures(rows), consistency(rows))))
    if rows:
        for name, plot in (("accuracy.svg", pose_plot(rows)), ("reliability.svg", reliability_plot(rows))):
            part = folder / (name + ".part")
            part.write_text(plot)
            part.rename(folder / name)
            print(f"plot: {folder / name}")
        if record:
            conditions = len({row["condition"] for row in rows})
            results.record(values(rows), command=record, conditions=f"the pictures that `make` fetches, {conditions} conditions, 100 m high, "
                           f"at most 1000 features, {len(of_method(rows, 'hoverlock', True))} flights")
