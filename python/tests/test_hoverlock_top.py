"""Hoverlock's own RTL against its bit-true model: for a small picture, the records of the committed Verilog equal those of
`hoverlock_models`. This is also the example of a bench that compares a design with a model."""

import re
from pathlib import Path

import numpy as np
import pytest

import hoverlock
import hoverlock_models as models
from hoverlock import Clock, ClockCycles, Design, RisingEdge, Session, with_timeout
from hoverlock.bus import AvalonMaster, AvalonSink, AvalonSource

VERILOG = Path(__file__).resolve().parents[2] / "rtl" / "verilog"
SOURCES = [VERILOG / line for line in (VERILOG / "hoverlock.f").read_text().split() if line.endswith(".v")]
design = Design(SOURCES, top="hoverlock_top")
EMISSION, CONTROL, SIZE, THRESHOLD, FEATURES, COMMIT = 0x08 >> 2, 0x0C >> 2, 0x14 >> 2, 0x18 >> 2, 0x28 >> 2, 0x30 >> 2
THRESHOLDS = (300, 200)


def picture(width, height, seed):
    """Blocks of random grey under some noise: corners of many sizes."""
    random = np.random.default_rng(seed)
    blocks = random.integers(8000, 56000, (height // 6 + 1, width // 7 + 1))
    return (blocks.repeat(6, 0).repeat(7, 1)[:height, :width] + random.integers(0, 500, (height, width))).astype(np.uint16)


async def ready(dut, width, height):
    Clock(dut.clock, 10, "ns").start()
    dut.reset.value = 1
    await ClockCycles(dut.clock, 4)
    dut.reset.value = 0
    await RisingEdge(dut.clock)
    csr = AvalonMaster(dut, "csr_", dut.clock, read_latency=1)
    await csr.write(SIZE, width | height << 16)
    await csr.write(THRESHOLD, THRESHOLDS[0] | THRESHOLDS[1] << 16)
    await csr.write(COMMIT, 1)
    await csr.write(CONTROL, 1)
    return csr


def test_the_rtl_sends_the_features_of_the_model():
    frame = picture(96, 80, seed=1)
    with Session(design) as session:
        session.run(ready, width=96, height=80)
        words = session.transfer(frame, "video_", "feature_", clock="clock", packet=frame.size, packets=1, stall=0.2)
    *found, trailer = models.records(words)
    assert np.array_equal(found, models.features(frame, THRESHOLDS)) and len(found) > 10
    assert words[-1][2] == len(found) and trailer["flags"] == 0x8000  # the trailer: features written, no errors


@hoverlock.test(timeout_time=10, timeout_unit="ms")
@hoverlock.parametrize(stall=[None, 0.5])
async def frames_follow_one_another(dut, stall):
    csr = await ready(dut, 64, 64)
    video = AvalonSource(dut, "video_", dut.clock, reset=dut.reset, symbol_bits=16)
    features = AvalonSink(dut, "feature_", dut.clock, reset=dut.reset, symbol_bits=32)
    video.pause(0.1, seed=1)
    features.pause(stall, seed=2)
    frames = [picture(64, 64, seed) for seed in (2, 3, 4)]
    for frame in frames:
        video.send(frame.ravel())
    for frame in frames:
        packet = await with_timeout(features.recv(), 2, "ms")
        # A beat of an Avalon stream has its first symbol on top, a record its first word at the bottom.
        *found, trailer = models.records(packet.symbols.reshape(-1, 8)[:, ::-1])
        assert np.array_equal(found, models.features(frame, THRESHOLDS)) and len(found) > 3
        assert await csr.read(FEATURES) == len(found)


@hoverlock.test(timeout_time=1, timeout_unit="ms")
async def software_recognises_the_hardware_by_its_hash(dut):
    csr = await ready(dut, 64, 64)
    assert await csr.read(EMISSION) == models.emission()
    header = (VERILOG.parent / "registers" / "hoverlock_registers.h").read_text()
    assert re.findall(r"#define HOVERLOCK_EMISSION_VALUE 0x([0-9a-f]{8})u", header) == [f"{models.emission():08x}"]


def test_a_step_of_one_dn_in_one_pixel_makes_rtl_and_model_differ():
    """The comparison is sensitive: the RTL gets one frame, the model the same with one pixel changed by 1 DN."""
    frame = picture(64, 64, seed=2)
    with Session(design) as session:
        session.run(ready, width=64, height=64)
        words = session.transfer(frame, "video_", "feature_", clock="clock", packet=frame.size, packets=1)
    *found, _ = models.records(words)
    assert np.array_equal(found, models.features(frame, THRESHOLDS))
    # At a feature: its response is the DoG of this pixel, and a step of 1 DN is two LSB of the DoG at its centre.
    other = frame.copy()
    other[found[0]["y"], found[0]["x"]] += 1
    assert not np.array_equal(found, models.features(other, THRESHOLDS))


def test_an_array_that_is_not_made_of_records_is_refused():
    with pytest.raises(ValueError, match="8 or 10 words"):
        models.records(np.zeros((2, 7), np.uint32))
