"""The bit-true model on numpy arrays, against its equations written again in numpy."""

from pathlib import Path

import numpy as np
import pytest

import hoverlock_models as models

# The normative table of the design point: sigma, look-ahead, g, g_j.
TABLE = [
    (2.0, 5, 24536, (40315, 47101, 56830, 64033, 65500)),
    (3.2, 5, 17102, (37685, 42386, 50478, 60180, 65021)),
    (5.12, 6, 11450, (35905, 38984, 44768, 53931, 62636, 65396)),
]


@pytest.mark.parametrize("sigma, look_ahead, g, g_j", TABLE)
def test_coefficients_are_those_of_the_table(sigma, look_ahead, g, g_j):
    made = models.coefficients(sigma, look_ahead)
    assert (made.g, made.g_j, made.saturated) == (g, g_j, ())
    error = made.a ** (2**look_ahead)
    assert models.look_ahead(made.a, error * 1.0001) == look_ahead


def test_impossible_coefficients_are_refused():
    with pytest.raises(ValueError):
        models.coefficients(-1.0, 5)
    with pytest.raises(ValueError):
        models.coefficients(2.0, 0)


def lerp(p, q, c):
    d = np.abs(q - p)
    t = (c * d + 2**15) >> 16
    return np.where(q >= p, p + t, p - t)


def smooth(state, g, g_j):
    """Columns, then rows, in the order of the hardware: look-ahead and recursion down, look-back and look-ahead across."""
    height, width = state.shape
    s = state.copy()
    for j, c in reversed(list(enumerate(g_j))):
        s = lerp(s[np.minimum(np.arange(height) + 2**j, height - 1)], s, c)
    for r in range(1, height):
        s[r] = lerp(s[r - 1], s[r], g)
    for j, c in enumerate(g_j):
        s = lerp(s[:, np.maximum(np.arange(width) - 2**j, 0)], s, c)
    for j, c in enumerate(g_j):
        s = lerp(s[:, np.minimum(np.arange(width) + 2**j, width - 1)], s, c)
    return s


def test_planes_equal_the_equations_in_numpy():
    frame = np.random.default_rng(3).integers(0, 65536, (50, 61), dtype=np.uint16)
    planes = models.planes(frame)
    state = frame.astype(np.int64) << 2
    smoothed = [smooth(state, g, g_j) for _, _, g, g_j in TABLE]
    dtypes = {"smoothed": np.uint32, "signed_dog": np.int32, "dog": np.uint16, "positive": np.bool_, "max_dog": np.uint16}
    assert {name: plane.dtype for name, plane in planes.items()} == {
        f"{name}{k}": np.dtype(dtype) for name, dtype in dtypes.items() for k in range(3 if name == "smoothed" else 2)
    }
    assert set(planes) < set(models.Planes.__annotations__)
    for index in range(3):
        assert np.array_equal(planes[f"smoothed{index}"], smoothed[index])
    for k in range(2):
        difference = smoothed[k] - smoothed[k + 1]
        assert np.array_equal(planes[f"signed_dog{k}"], difference)
        assert np.array_equal(planes[f"dog{k}"], np.minimum((np.abs(difference) + 1) >> 1, 2**15 - 1))
        assert np.array_equal(planes[f"positive{k}"], difference >= 0)


def test_features_are_the_maxima_of_the_dog_planes():
    frame = np.random.default_rng(4).integers(0, 65536, (80, 90), dtype=np.uint16)
    planes, found = models.planes(frame), models.features(frame, (300, 200))
    assert found.dtype == models.FEATURE and len(found) > 5
    places = []
    for k, threshold in enumerate((300, 200)):
        dog = planes[f"dog{k}"].astype(int)
        for y in range(18, 80 - 18):
            for x in range(18, 90 - 18):
                window = dog[y - 3 : y + 4, x - 3 : x + 4].ravel()
                if dog[y, x] >= threshold and (window[:24] < dog[y, x]).all() and (window[25:] <= dog[y, x]).all():
                    places.append((y, x, k, dog[y, x]))
    assert [(int(f["y"]), int(f["x"]), int(f["flags"]) & 1, int(f["response"])) for f in found] == sorted(places)


def test_wrong_frames_are_refused():
    for wrong in (np.zeros(5, np.uint16), np.zeros((4, 4)), np.full((4, 4), 70000), np.zeros((0, 4), np.uint16)):
        with pytest.raises(ValueError):
            models.features(wrong)
    assert len(models.features(np.full((40, 40), 1000, np.uint16))) == 0
    small = (Path(__file__).parents[2] / "designs/small.toml").read_text()
    frame = np.full((40, 40), 255, np.uint16)
    assert len(models.features(frame, design_point=small)) == 0
    frame[3, 7] = 256
    for extract in (models.features, models.planes):
        with pytest.raises(ValueError, match=r"the pixel at \(7, 3\) is 256: .* 8 bits, 0 to 255; a 16-bit sample v is v >> 8"):
            extract(frame, design_point=small)
    with pytest.raises(ValueError, match="1 thresholds for a design of 2 scale pairs"):
        models.features(frame, (40,))


def test_three_scale_pairs_have_records_of_ten_words():
    design = (Path(__file__).parents[2] / "designs/three_scales.toml").read_text()
    frame = np.random.default_rng(5).integers(0, 4096, (80, 90), dtype=np.uint16)
    found = models.features(frame, (20, 20, 20), design_point=design)
    third = found[found["flags"] & 4 != 0]
    planes = models.planes(frame, design_point=design)
    assert found.dtype == models.FEATURE_OF_THREE_PAIRS and len(third) > 2
    assert set(planes) == set(models.Planes.__annotations__)
    assert np.array_equal(third["response"], planes["dog2"][third["y"], third["x"]])
    assert "sigma" in models.design_point()
