"""Upsets from a bench: what each is, in a design whose copies outvote one."""

import pytest

from hoverlock import BuildError, Clock, ClockCycles, Design, FallingEdge
from hoverlock.fault import CLASSES, Campaign, Register, Upset, campaign

design = Design("designs/voter.v", top="voter")


async def bench(dut, *, checks=False):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0
    seen = []
    for cycle in range(20):
        await FallingEdge(dut.clk)
        seen.append(int(dut.count.value))
        if checks:
            assert seen[-1] == cycle
    return seen


async def still(dut):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 5)
    return int(dut.count.value)


def test_a_copy_is_outvoted_and_a_single_register_is_not():
    voted = campaign(design, bench, ["first", "second", "third", "unused"], upsets=30, seed=7)
    assert voted.counts == {"masked": 30, "detected": 0, "silent": 0, "hang": 0}
    assert sorted(voted.registers) == [Register(name, 1, 8) for name in ("first", "second", "third", "unused")]
    # In the reset the next edge repairs it.
    plain = campaign(design, bench, ["plain"], upsets=30, seed=7)
    assert all(upset.outcome == "silent" for upset in plain.upsets if 1 < upset.cycle < plain.cycles), plain.upsets
    assert all(upset.outcome == "masked" for upset in plain.upsets if upset.cycle == 1), plain.upsets
    assert len({upset.bit for upset in plain.upsets}) > 5 and len({upset.cycle for upset in plain.upsets}) > 8


def test_a_failed_check_is_a_detection_and_finish_is_a_hang():
    checked = campaign(design, bench, ["plain"], upsets=20, seed=3, arguments={"checks": True})
    assert checked.counts["silent"] == 0 and checked.counts["detected"] > 14, checked.counts
    stopped = campaign(design, bench, ["state"], upsets=20, seed=3)
    assert set(stopped.counts) == set(CLASSES) and stopped.counts["hang"] > 14, stopped.counts


def test_the_same_seed_draws_the_same_upsets():
    one, again, other = (campaign(design, bench, ["plain"], upsets=20, seed=seed) for seed in (5, 5, 6))
    assert one == again and one.upsets != other.upsets


def test_a_campaign_that_would_mean_nothing_is_refused():
    with pytest.raises(BuildError, match=r"no internal signal 'count\*'"):
        campaign(design, bench, ["count*"], upsets=5)
    with pytest.raises(ValueError, match="no falling edge of 'rst' in the bench"):
        campaign(design, still, ["plain"], clock="rst", upsets=5)
    runs = iter(range(10))

    async def varies(dut):
        await bench(dut)
        return next(runs)

    with pytest.raises(ValueError, match="different values in two runs"):
        campaign(design, varies, ["plain"], upsets=5)


def test_shares_have_their_intervals():
    upsets = [Upset("a", 0, 0, 1, "masked")] * 9 + [Upset("b.c", 0, 0, 1, "silent")]
    found = Campaign([], 1, upsets)
    share, low, high = found.share("silent")
    assert share == 0.1 and abs(low - 0.0179) < 1e-4 and abs(high - 0.4042) < 1e-4
    assert found.of("b.*").counts["silent"] == 1 and found.of("x").share("hang") == (0.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="'lost' is no class"):
        found.share("lost")
