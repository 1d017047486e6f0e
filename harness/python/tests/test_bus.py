"""Bus models from Python, and whole frames as numpy arrays."""

import numpy as np
import pytest

import hoverlock
from hoverlock import Clock, ClockCycles, Design, RisingEdge, Session, with_timeout
from hoverlock.bus import AvalonMaster, AvalonMonitor, AvalonSink, AvalonSource, Frame

stream = Design("../../tests/designs/stream.v", top="stream", parameters={"LINE": 16})
registers = Design("designs/registers.v", top="registers")


def expected(frames, line=16):
    """What the design does: a recursion that begins afresh with each packet, and the sample one line earlier."""
    memory, at, out = [0] * line, 0, []
    for frame in frames:
        state, words = 0, []
        for index, sample in enumerate(int(s) for s in frame):
            fed = sample << 8
            state = fed if index == 0 else (state - (state >> 2) + (fed >> 2)) & 0xFFFF
            words.append(state ^ memory[at])
            memory[at], at = sample, (at + 1) % line
        out.append(words)
    return out


async def reset(dut):
    Clock(dut.clk, 10, "ns").start()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0


@hoverlock.test(design=stream, timeout_time=1, timeout_unit="ms")
@hoverlock.parametrize(idle=[None, 0.5, [0, 1, 1]], stall=[None, 0.3, [1, 0]], length=[1, 2, 33])
async def frames_pass_whatever_the_pauses(dut, idle, stall, length):
    source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
    sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
    monitor = AvalonMonitor(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
    source.pause(idle, seed=1)
    sink.pause(stall, seed=2)
    await reset(dut)
    generator = np.random.default_rng(hoverlock.running().seed)
    frames = [generator.integers(0, 256, length, dtype=np.uint8) for _ in range(4)]
    for frame in frames:
        source.send(frame)
    await with_timeout(source.drained(), 500, "us")
    for words in expected(frames):
        received = await sink.recv()
        assert isinstance(received, Frame) and received.symbols.tolist() == words
        assert (await monitor.recv()).symbols.tolist() == words
    assert (source.sent, source.pending, sink.beats) == (4 * length, 0, 4 * length)
    assert len(sink) == 0 and sink.try_recv() is None and sink.violations == []


@hoverlock.test(design=registers)
async def a_master_reads_what_it_wrote(dut):
    Clock(dut.clk, 10, "ns").start()
    csr = AvalonMaster(dut, "csr_", dut.clk)
    await RisingEdge(dut.clk)
    for address in range(4):
        await csr.write(address, 0x1000_0000 * address + 7)
    for address in range(4):
        assert await csr.read(address) == 0x1000_0000 * address + 7
    # Two tasks at a time: the master takes one access after the other.
    tasks = [hoverlock.start_soon(csr.read(address)) for address in (3, 1)]
    assert [await task & 0xF000_0000 for task in tasks] == [0x3000_0000, 0x1000_0000]
    with pytest.raises(hoverlock.RangeError):
        await csr.write(4, 0)


@pytest.mark.parametrize("stall", [None, 0.4, [0, 0, 1]])
@pytest.mark.parametrize("idle", [None, 0.2])
def test_a_transfer_gives_what_the_design_does_and_a_report(idle, stall):
    frame = np.random.default_rng(5).integers(0, 256, 5000, dtype=np.uint8)
    with Session(stream) as session:
        session.run(reset)
        received = session.transfer(frame, idle=idle, stall=stall, packet=1000, seed=4)
        report = session.report
        again = session.transfer(frame[:10], packet=10)
    words = [word for part in expected(frame.reshape(5, 1000)) for word in part]
    assert received.dtype == np.uint16 and received.tolist() == words
    assert (report.sent, report.received, report.packets) == (5000, 5000, 5) and report.cycles >= 5000
    assert len(again) == 10


def test_wrong_arrays_are_refused():
    with Session(stream) as session:
        session.run(reset)
        with pytest.raises(hoverlock.HoverlockError, match="elements are of 8 bits"):
            session.transfer(np.zeros(4, dtype=np.uint16))
        with pytest.raises(TypeError, match="float64"):
            session.transfer(np.zeros(4))
        with pytest.raises(hoverlock.NoSuchSignal, match="nothing_data"):
            session.transfer(np.zeros(4, dtype=np.uint8), output="nothing_")
        with pytest.raises(ValueError, match="lets nothing through"):
            session.transfer(np.zeros(4, dtype=np.uint8), stall=[1, 1])
        with pytest.raises(hoverlock.HoverlockError):
            session.transfer(np.zeros(4, dtype=np.uint8), expect=5, most_cycles=100)
        # After all this it still works.
        assert len(session.transfer(np.zeros(4, dtype=np.uint8))) == 4
    with pytest.raises(hoverlock.SimulationError, match="closed"):
        session.run(reset)


def test_waves_and_coverage_are_written(tmp_path):
    async def bench(dut):
        await reset(dut)
        waves = hoverlock.running().simulation.start_waves(tmp_path / "chosen.vcd", signals=["clk", "out_data"])
        await ClockCycles(dut.clk, 10)
        waves.stop()

    with Session(stream.changed(waves="fst", coverage=True)) as session:
        session.simulation.start_waves(tmp_path / "all.fst")
        session.run(bench)
        session.simulation.write_coverage(tmp_path / "coverage.dat")
    text = (tmp_path / "chosen.vcd").read_text()
    assert "out_data" in text and "in_valid" not in text
    assert (tmp_path / "all.fst").stat().st_size > 100 and (tmp_path / "coverage.dat").stat().st_size > 100
