"""Tables (Markdown) and plots (SVG) of the scores of `accuracy.py`. The plots show the held-back ground."""

import csv
import math
import sys
from collections import defaultdict
from pathlib import Path
from statistics import mean, median

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "setup"))
import results  # noqa: E402

METHODS = ["hoverlock", "orb", "akaze", "brisk", "sift", "phase"]
COLOURS = ["#c0392b", "#2471a3", "#1e8449", "#b9770e", "#7d3c98"]
# Largest error at the centre of the frame of a correct motion, px.
MAX_CENTRE_ERROR_PX = 2.0


def rms(values):
    """Returns the root mean square, NaN for an empty list."""
    return math.sqrt(mean(v * v for v in values)) if values else math.nan


def scores(folder: Path, tuning: bool) -> list[dict]:
    """Reads the flights over the ground used for tuning, or over the held-back half."""
    with open(folder / "scores.csv", newline="") as file:
        return [row for row in csv.DictReader(file) if row["tuning"] == str(int(tuning))]


def numbers(rows, name):
    """Returns the numbers of a column, without empty cells."""
    return [float(row[name]) for row in rows if row[name] not in ("", "NaN")]


def first(rows):
    """Returns the flights that all methods have."""
    return [row for row in rows if row["flight"] == "0"]


def consistency(rows) -> str:
    """Returns a table of the NEES of the displacement by condition.

    It is 2 for a correct covariance, within 4 / sqrt(flights) by chance. `outside` counts the errors beyond three
    estimated standard errors. `features` are features alone, as on the ARM.
    """
    lines = ["| condition | flights | pose, cm | NEES | outside | features: pose, cm | NEES | outside | no pose |",
             "|---|" + "---|" * 8]
    for condition in dict.fromkeys(row["condition"] for row in rows):
        cells = []
        for method in ("hoverlock", "features"):
            at = [row for row in rows if row["condition"] == condition and row["method"] == method]
            nees = numbers(at, "nees")
            cells += [f"{100 * rms(numbers(at, 'pose')):.1f}", f"{mean(nees):.1f}", str(sum(v > 9 for v in nees))]
        lines.append(f"| {condition} | {len(at)} | " + " | ".join(cells) + f" | {len(at) - len(nees)} |")
    return "\n".join(lines)


def markdown(rows) -> str:
    """Returns a table with one line per method; `-` means no value."""
    lines = ["| method | first matches right | last | localisation, px | centre, px | pose wide, cm | narrow | relief "
             "| no pose | features, ms | matching, ms |", "|---|" + "---|" * 10]
    for method in METHODS:
        of = [row for row in rows if row["method"] == method]
        if not of:
            continue
        at = lambda condition: [row for row in of if row["condition"] == condition]
        shown = lambda value, form: "-" if math.isnan(value) else format(value, form)
        pose = [shown(100 * rms(numbers(at(c), "pose")), ".1f") for c in ("nominal", "narrow", "relief")]
        local = numbers(at("nominal"), "localisation")
        matched = mean(numbers(of, "first")) if method != "phase" else math.nan
        last = mean(numbers(of, "last")) if method != "phase" else math.nan
        cells = [method, shown(matched, ".3f"), shown(last, ".3f"), shown(mean(local) if local else math.nan, ".3f"),
                 shown(rms(numbers(at("nominal"), "centre")), ".4f"), *pose,
                 f"{sum(row['pose'] == '' for row in of)} of {len(of)}",
                 f"{median(numbers(of, 'detect')):.0f}", f"{median(numbers(of, 'match')):.0f}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def failures(rows) -> str:
    """Returns a table of the flights without a motion or with an error above MAX_CENTRE_ERROR_PX at the centre."""
    lines = [f"| method | no motion | centre off by more than {MAX_CENTRE_ERROR_PX:g} px | flights |", "|---|---|---|---|"]
    for method in METHODS:
        of = [row for row in rows if row["method"] == method]
        if of:
            centres = numbers(of, "centre")
            lines.append(f"| {method} | {len(of) - len(centres)} | {sum(c > MAX_CENTRE_ERROR_PX for c in centres)} | {len(of)} |")
    return "\n".join(lines)


def values(rows, flights) -> dict[str, float]:
    """Returns the numbers of both tables by their keys in `docs/results.json`; `flights` are those that all methods made."""
    found = {}
    names = dict(zip(METHODS, ["hoverlock", "ORB", "AKAZE", "BRISK", "SIFT", "phase_correlation"]))
    for method, name in names.items():
        of = [row for row in flights if row["method"] == method]
        at = {condition: [row for row in of if row["condition"] == condition] for condition in ("nominal", "narrow", "relief")}
        columns = {"centre": (rms(numbers(at["nominal"], "centre")), 4), "no_pose": (sum(row["pose"] == "" for row in of), 0)}
        if method != "phase":
            local = numbers(at["nominal"], "localisation")
            columns |= {"first": (mean(numbers(of, "first")), 3), "final": (mean(numbers(of, "last")), 3),
                        "localisation": (mean(local) if local else math.nan, 3)}
            columns |= {key: (100 * rms(numbers(at[condition], "pose")), 1)
                        for key, condition in (("wide", "nominal"), ("narrow", "narrow"), ("relief", "relief"))}
        found |= {f"accuracy.methods.{name}.{key}": round(value, digits) if digits else int(value)
                  for key, (value, digits) in columns.items()}
        found["accuracy.methods.flights"] = len(of)
    for condition in dict.fromkeys(row["condition"] for row in rows):
        key = "accuracy.covariance." + condition.replace(" ", "_").replace(".", "")
        for method, prefix in (("hoverlock", ""), ("features", "features_")):
            at = [row for row in rows if row["condition"] == condition and row["method"] == method]
            nees = numbers(at, "nees")
            found |= {f"{key}.{prefix}pose": round(100 * rms(numbers(at, "pose")), 1), f"{key}.{prefix}nees": round(mean(nees), 1),
                      f"{key}.{prefix}outside": sum(v > 9 for v in nees)}
        found |= {f"{key}.flights": len(at), f"{key}.no_pose": len(at) - len(nees)}
    for method, prefix in (("hoverlock", ""), ("features", "features_")):
        nees = numbers([row for row in rows if row["method"] == method], "nees")
        found |= {f"accuracy.covariance.all.{prefix}nees": round(mean(nees), 2),
                  f"accuracy.covariance.all.{prefix}outside": sum(v > 9 for v in nees)}
    found["accuracy.covariance.all.flights"] = sum(row["method"] == "hoverlock" for row in rows)
    return found


def text(x, y, words, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{words}</text>'


def frame(width, height, body) -> str:
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
            f'font-size="12"><rect width="{width}" height="{height}" fill="white"/>\n' + "\n".join(body) + "\n</svg>\n")


def pose_plot(rows) -> str:
    """Plots the root mean square error of the displacement by condition; all methods share the same pose fit."""
    by = defaultdict(list)
    for row in rows:
        by[row["condition"], row["method"]] += numbers([row], "pose")
    conditions = list(dict.fromkeys(row["condition"] for row in rows))
    left, right, top, bottom = 60, 880, 40, 330
    low, high = -2.3, 0.5
    y = lambda v: bottom - (math.log10(v) - low) / (high - low) * (bottom - top)
    x = lambda i: left + (i + 0.5) * (right - left) / len(conditions)
    body = [text(470, 20, "Error of the displacement, rms of the flights over held-back ground, m")]
    for v in (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2):
        body += [f'<path d="M{left} {y(v):.1f}H{right}" stroke="#ddd"/>', text(left - 6, y(v) + 4, f"{v:g}", "end")]
    for i, condition in enumerate(conditions):
        body.append(text(x(i), bottom + 18, condition.replace("narrow noisy", "nar. noisy")))
        for m, method in enumerate(METHODS[:5]):
            values = by[condition, method]
            if values:
                v = min(max(rms(values), 10**low), 10**high)
                radius = 5 if m == 0 else 3.5
                body.append(f'<circle cx="{x(i) + 7 * (m - 2):.1f}" cy="{y(v):.1f}" r="{radius}" fill="{COLOURS[m]}"/>')
    for m, method in enumerate(METHODS[:5]):
        body += [f'<circle cx="{250 + 95 * m}" cy="{bottom + 42}" r="5" fill="{COLOURS[m]}"/>',
                 text(260 + 95 * m, bottom + 46, method, "start")]
    return frame(900, 390, body)


def reliability_plot(rows) -> str:
    """Plots the fraction of the flights whose error is within the ellipse of a given probability."""
    probabilities = sorted(1 - math.exp(-v / 2) for v in numbers([r for r in rows if r["method"] == "hoverlock"], "nees"))
    left, top, side = 60, 40, 320
    place = lambda p, q: f"{left + side * p:.1f} {top + side * (1 - q):.1f}"
    body = [text(220, 20, f"Reliability of the covariance, {len(probabilities)} flights")]
    body.append(f'<rect x="{left}" y="{top}" width="{side}" height="{side}" fill="none" stroke="#999"/>')
    for p in (0, 0.2, 0.4, 0.6, 0.8, 1):
        body += [text(left + side * p, top + side + 18, f"{p:g}"), text(left - 6, top + side * (1 - p) + 4, f"{p:g}", "end")]
    body.append(f'<path d="M{place(0, 0)}L{place(1, 1)}" stroke="#999" stroke-dasharray="4 4"/>')
    steps = [place(p, (i + 1) / len(probabilities)) for i, p in enumerate(probabilities)]
    body.append(f'<path d="M{place(0, 0)}L{"L".join(steps)}" fill="none" stroke="{COLOURS[0]}" stroke-width="2"/>')
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
            print(f"\n## {half}\n\n" + "\n\n".join((markdown(first(rows)), failures(first(rows)), consistency(rows))))
    if rows:
        for name, plot in (("accuracy.svg", pose_plot(first(rows))), ("reliability.svg", reliability_plot(rows))):
            part = folder / (name + ".part")
            part.write_text(plot)
            part.rename(folder / name)
            print(f"plot: {folder / name}")
        if record:
            results.record(values(rows, first(rows)), command=record)
