"""Hovers and co-simulations as functions: results, errors, Ctrl-C, threads."""

import csv
import io
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from hoverlock_models import cosim

SHORT = {"scene": "helipad-in-mist", "seconds": 1.0, "seed": 3}


def without_wall_time(result):
    return {name: value for name, value in result.summary.items() if name != "wall_s"}


def test_a_hover_has_summary_checks_table_and_page():
    result = cosim.hover(**SHORT)
    summary = result.summary
    assert summary["scene"] == "helipad-in-mist" and summary["seed"] == 3 and summary["features"] == "fixed"
    assert summary["pass"] is True and summary["reason"] is None and result.checks
    rows = list(csv.DictReader(io.StringIO(result.table())))
    assert len(rows) == summary["frames"] > 10
    assert 0 < summary["rms_m"] < summary["max_m"]
    assert "helipad-in-mist" in result.page("a test") and "a test" in result.page("a test")


def test_hovers_in_threads_give_the_results_of_one_after_the_other():
    seeds = (1, 2)
    alone = [without_wall_time(cosim.hover(**{**SHORT, "seed": seed})) for seed in seeds]
    with ThreadPoolExecutor(2) as threads:
        together = list(threads.map(lambda seed: without_wall_time(cosim.hover(**{**SHORT, "seed": seed})), seeds))
    assert together == alone and alone[0] != alone[1]


@pytest.mark.parametrize(
    "changed, message",
    [
        ({"scene": "nowhere"}, "scene nowhere: no such scene"),
        ({"design": "nothing"}, "nothing: no such file, and no design of that name"),
        ({"design": "dog_bits=99"}, "dog_bits"),
        ({"features": "none"}, "features is 'none', and must be one of float, fixed, rtl"),
        ({"view": "all"}, "view is 'all'"),
        ({"seconds": 0.0}, "seconds is 0"),
        ({"seconds": float("nan")}, "seconds is NaN"),
    ],
)
def test_an_invalid_argument_is_one_clear_line(changed, message):
    with pytest.raises(ValueError, match=message) as raised:
        cosim.hover(**{**SHORT, **changed})
    assert "\n" not in str(raised.value) and not str(raised.value).startswith("-")


def test_a_point_of_a_campaign_that_is_not_one_is_refused():
    for row in ("", "no point", "field,50.0,3.0,1.0,fixed,kt27,00000000,1"):
        with pytest.raises(ValueError) as raised:
            cosim.fly_point(row)
        assert str(raised.value) and "\n" not in str(raised.value).strip()


def test_a_folder_without_frames_is_refused(tmp_path):
    with pytest.raises(ValueError) as raised:
        cosim.replay(tmp_path)
    assert str(tmp_path) in str(raised.value)


def test_ctrl_c_ends_a_hover():
    script = (
        "import signal\nfrom hoverlock_models import cosim\n"
        "signal.signal(signal.SIGALRM, signal.default_int_handler)\nsignal.setitimer(signal.ITIMER_REAL, 3)\n"
        "try:\n    cosim.hover('helipad-in-mist', seconds=3600)\nexcept KeyboardInterrupt:\n    print('interrupted')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.stdout == "interrupted\n", done.stdout + done.stderr
