"""Every bus model from Python: length x data x idle x back-pressure x width, each rule of the checkers broken once, and the
path of whole arrays against that of beats.

The data of each test come from the seed of the run, which is named when a test fails."""

import numpy as np
import pytest

import hoverlock
from hoverlock import Clock, ClockCycles, Design, FallingEdge, ProtocolError, RisingEdge, Session, start_soon, with_timeout
from hoverlock.bus import (
    AvalonMaster,
    AvalonMemory,
    AvalonMonitor,
    AvalonSink,
    AvalonSource,
    AxiLiteMaster,
    AxiLiteMemory,
    AxiMaster,
    AxiMonitor,
    AxiSink,
    AxiSource,
    Frame,
)

FOLDER = "../../tests/designs/"
WIRES = "designs/wires.v"
stream = Design(FOLDER + "stream.v", top="stream", parameters={"LINE": 16})
copier_mm = Design(FOLDER + "copier_mm.v", top="copier_mm")
copier_axi = Design(FOLDER + "copier_axi.v", top="copier_axi")
registers_axi = Design(FOLDER + "registers_axi.v", top="registers_axi")


def generator():
    return np.random.default_rng(hoverlock.running().seed)


async def reset(dut):
    signal, active = (dut.rst, 1) if "rst" in dut else (dut.rst_n, 0)
    Clock(dut.clk, 10, "ns").start()
    signal.value = active
    await ClockCycles(dut.clk, 4)
    signal.value = 1 - active
    await RisingEdge(dut.clk)


# ---- Avalon-ST, with packets, empty, channel and error


async def pass_frames(dut, latency, idle, stall):
    options = {"reset": dut.rst, "ready_latency": latency}
    source = AvalonSource(dut, "in_", dut.clk, **options)
    sink = AvalonSink(dut, "out_", dut.clk, **options)
    monitors = [AvalonMonitor(dut, prefix, dut.clk, **options) for prefix in ("in_", "out_")]
    source.pause(idle, seed=11)
    sink.pause(stall, seed=12)
    await reset(dut)
    random, lanes = generator(), len(dut.in_data) // 8
    # The last is longer than the design's memory: it fills up where the sink holds back.
    lengths = [1, 2, lanes - 1 or 1, lanes, lanes + 1, 5 * lanes + 3, 40 * lanes]
    frames = [
        Frame(random.integers(0, 256, n, dtype=np.uint8), channel=int(random.integers(16)), error=int(random.integers(2)))
        for n in lengths
    ]
    for frame in frames:
        source.send(frame)
    for number, frame in enumerate(frames):
        for heard in (await with_timeout(sink.recv(), 100, "us"), *[await m.recv() for m in monitors]):
            assert (bytes(heard), heard.channel, heard.error) == (bytes(frame), frame.channel, frame.error), number
    beats = sum(-(-n // lanes) for n in lengths)
    assert [source.sent, sink.beats, *(m.beats for m in monitors)] == [beats] * 4
    assert source.pending == 0 and all(heard.violations == [] for heard in (sink, *monitors))


@pytest.mark.parametrize("bits, empty", [(8, 1), (32, 2), (128, 4), (512, 6)])
@pytest.mark.parametrize("latency", [0, 1, 3])
def test_avalon_frames_of_any_length_width_and_latency(bits, empty, latency):
    parameters = {"WIDTH": bits, "EMPTY": empty, "LATENCY": latency}
    design = Design(FOLDER + "avalon_fifo.v", top="avalon_fifo", parameters=parameters)
    for idle in (None, 0.5, [0, 1, 1]):
        for stall in (None, 0.4, [1, 1, 0]):
            arguments = {"latency": latency, "idle": idle, "stall": stall}
            hoverlock.simulate(design, pass_frames, seed=bits + latency, wall_limit=60, arguments=arguments)


async def break_stream(dut, beats, latency=0, ready=1, strict=False):
    """Puts beats onto the wires, one a cycle from 100 ns on, and gives what the sink's checker says."""
    Clock(dut.clk, 10, "ns").start()
    axi = "out_tdata" in dut
    sink = AxiSink(dut, "out_", dut.clk, strict=strict) if axi else AvalonSink(
        dut, "out_", dut.clk, ready_latency=latency, strict=strict
    )
    sink.pause(None if ready else [1] * 50 + [0])
    await ClockCycles(dut.clk, 10)
    for beat in beats:
        for name in ("valid", "data", "first", "last", "empty", "channel", "id"):
            if name in dut:
                getattr(dut, name).value = beat.get(name, 0)
        await RisingEdge(dut.clk)
    dut.valid.value = 0
    await ClockCycles(dut.clk, 3)
    return sink.violations


V, F, L = {"valid": 1}, {"first": 1}, {"last": 1}
# The first beat stands on the wires at the edge of 100 ns (the first edge is at 0), the second at 110 ns.
RULES = [
    ([{**V, **F, **L}], {"latency": 1, "ready": 0}, "out at 100 ns: valid without ready 1 cycles before"),
    ([{**V, **F, **L}, {}], {"ready": 0}, "out at 110 ns: valid fell before ready came"),
    ([{**V, **F}, {**V, **F, "data": 1}], {"ready": 0}, "out at 110 ns: the beat changed while valid waited for ready"),
    ([V], {}, "out at 100 ns: a beat outside of a packet: no startofpacket"),
    ([{**V, **F}, {**V, **F}], {}, "out at 110 ns: startofpacket inside a packet"),
    ([{**V, **F, "empty": 1}], {}, "out at 100 ns: empty is 1 before endofpacket"),
    ([{**V, **F}, {**V, **L, "channel": 2}], {}, "out at 110 ns: channel changed inside a packet"),
]


@pytest.mark.parametrize("beats, how, said", RULES, ids=[said.split(": ", 1)[1] for _, _, said in RULES])
def test_each_rule_of_avalon_st_is_named_with_its_time(beats, how, said):
    design = Design(WIRES, top="wires_st")
    assert said in hoverlock.simulate(design, break_stream, arguments={"beats": beats, **how})
    with pytest.raises(ProtocolError) as caught:
        hoverlock.simulate(design, break_stream, arguments={"beats": beats, **how, "strict": True})
    assert str(caught.value) == said


AXI_RULES = [
    ([{**V, **L}, {}], {"ready": 0}, "out at 110 ns: valid fell before ready came"),
    ([V, {**V, "data": 1}], {"ready": 0}, "out at 110 ns: the beat changed while valid waited for ready"),
    ([V, {**V, **L, "id": 1}], {}, "out at 110 ns: channel changed inside a packet"),
]


@pytest.mark.parametrize("beats, how, said", AXI_RULES, ids=[said.split(": ", 1)[1] for _, _, said in AXI_RULES])
def test_each_rule_of_axi_stream_is_named_with_its_time(beats, how, said):
    design = Design(WIRES, top="wires_axis")
    assert said in hoverlock.simulate(design, break_stream, arguments={"beats": beats, **how})


def test_what_keeps_the_rules_is_not_complained_of():
    good = [{**V, **F}, {**V, "data": 1}, {**V, **L, "empty": 1}, {}, {**V, **F, **L, "channel": 1}]
    assert hoverlock.simulate(Design(WIRES, top="wires_st"), break_stream, arguments={"beats": good}) == []
    good = [V, {**V, "data": 1}, {**V, **L}, {}, {**V, **L, "id": 1}]
    assert hoverlock.simulate(Design(WIRES, top="wires_axis"), break_stream, arguments={"beats": good}) == []


def test_a_monitor_listens_inside_the_design():
    async def bench(dut):
        Clock(dut.clk, 10, "ns").start()
        monitors = [AxiMonitor(dut.lane[at].u_wires, "out_", dut.clk, symbol_bits=16) for at in (0, 1)]
        await RisingEdge(dut.clk)
        for word in (1, 2, 3):
            dut.valid.value, dut.data.value, dut.last.value = 1, word, word == 3
            await RisingEdge(dut.clk)
        dut.valid.value = 0
        return [(await with_timeout(monitor.recv(), 1, "us")).symbols.tolist() for monitor in monitors]

    design = Design(WIRES, top="wires_inside", internals=["lane[*].u_wires.out_*"])
    assert hoverlock.simulate(design, bench) == [[1, 2, 3], [0xFFFE, 0xFFFD, 0xFFFC]]


def test_both_sides_of_a_stream_are_cleared():
    async def bench(dut):
        source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
        sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst)
        await reset(dut)
        source.send(range(40))
        source.send([7, 8])
        await ClockCycles(dut.clk, 5)
        dut.rst.value = 1
        await ClockCycles(dut.clk, 2)
        assert source.pending == 1, "the beat of the second packet"
        source.clear()
        sink.clear()
        dut.rst.value = 0
        await ClockCycles(dut.clk, 2)
        source.send([1, 2, 3])
        assert (await with_timeout(sink.recv(), 1, "us")).symbols.tolist() == [1, 2, 3] and sink.try_recv() is None

    hoverlock.simulate(Design(FOLDER + "avalon_fifo.v", top="avalon_fifo"), bench)


# ---- AXI4-Stream


@pytest.mark.parametrize("lanes", [1, 4, 64])
def test_axi_frames_of_any_length_and_width(lanes):
    design = Design(FOLDER + "axis_adapter.v", top="axis_adapter", parameters={"S": lanes, "M": lanes, "USER": 3})

    async def bench(dut, idle, stall):
        options = {"reset": dut.rst_n, "reset_active": False}
        source = AxiSource(dut, "s_axis_", dut.clk, **options)
        sink, monitor = (kind(dut, "m_axis_", dut.clk, **options) for kind in (AxiSink, AxiMonitor))
        source.pause(idle, seed=21)
        sink.pause(stall, seed=22)
        await reset(dut)
        random = generator()
        frames = [random.integers(0, 256, n, dtype=np.uint8) for n in (1, lanes, lanes + 1, 3 * lanes + 2)]
        for number, frame in enumerate(frames):
            source.send(frame, error=number)
        for number, frame in enumerate(frames):
            for heard in (await with_timeout(sink.recv(), 100, "us"), await monitor.recv()):
                assert bytes(heard) == bytes(frame) and heard.error == number

    for idle in (None, 0.5, [1, 0]):
        for stall in (None, 0.4, [1, 1, 0]):
            hoverlock.simulate(design, bench, seed=lanes, wall_limit=60, arguments={"idle": idle, "stall": stall})


# ---- Avalon-MM


@pytest.mark.parametrize("stall", [0, 3])
@pytest.mark.parametrize("latency", [1, 5])
def test_an_avalon_master_reaches_registers(stall, latency):
    parameters = {"STALL": stall, "LATENCY": latency}
    design = Design(FOLDER + "registers_mm.v", top="registers_mm", parameters=parameters)

    async def bench(dut):
        await reset(dut)
        csr, random = AvalonMaster(dut, "csr_", dut.clk), generator()
        words = [0] * 8
        for _ in range(100):
            at, word, mask = (int(random.integers(top)) for top in (8, 2**32, 16))
            if random.random() < 0.5:
                await csr.write(at, word, bytes=mask)
                kept = sum(0xFF << (8 * b) for b in range(4) if not mask >> b & 1)
                words[at] = words[at] & kept | word & ~kept & 0xFFFF_FFFF
            assert await csr.read(at) == words[at]
        # Asked at once by several tasks, it takes one access after the other.
        tasks = [start_soon(csr.read(at)) for at in range(8)]
        assert [await task for task in tasks] == words

    hoverlock.simulate(design, bench, seed=10 * stall + latency, wall_limit=60)


async def copy(dut, memory, count):
    """Lets the design copy words, adding 1, and looks at the memory as arrays."""
    words = generator().integers(0, 2**32, count, dtype=np.uint64)
    memory.write(0, words)
    await reset(dut)
    dut.count.value, dut.start.value = count, 1
    await RisingEdge(dut.clk)
    dut.start.value = 0
    await with_timeout(RisingEdge(dut.done), 200, "us")
    return words


@hoverlock.test(design=copier_mm)
@hoverlock.parametrize(stall=[None, 0.5, [1, 1, 0]], latency=[(1, 1), (1, 6)], count=[1, 40])
async def an_avalon_memory_serves_a_master(dut, stall, latency, count):
    memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst)
    memory.stall(stall, seed=31)
    memory.latency(*latency, seed=32)
    words = await copy(dut, memory, count)
    copied = memory.read(256, count)
    assert copied.dtype == np.uint64 and np.array_equal(copied, (words + 1) & 0xFFFF_FFFF)
    assert np.array_equal(memory.read(0, count), words) and memory.accesses == 2 * count
    assert memory[256 + count] == 0
    with pytest.raises(ValueError, match="latency of 0"):
        memory.latency(0, 3)


async def break_registers(dut, steps, stall):
    Clock(dut.clk, 10, "ns").start()
    memory = (AxiLiteMemory if "m_awvalid" in dut else AvalonMemory)(dut, "m_", dut.clk)
    memory.stall(stall)
    await ClockCycles(dut.clk, 10)
    for step in steps:
        for name in ("read", "write", "aw", "w", "ar", "address", "data"):
            if name in dut:
                getattr(dut, name).value = step.get(name, 0)
        await RisingEdge(dut.clk)
    await ClockCycles(dut.clk, 2)


HELD = [1] * 50 + [0]
REGISTER_RULES = [
    ("wires_mm", [{"read": 1, "write": 1}], None, "m at 100 ns: read and write together"),
    ("wires_mm", [{"read": 1}, {"read": 1, "address": 4}], HELD, "m at 110 ns: the command changed while waitrequest was 1"),
    ("wires_mm", [{"write": 1}, {"write": 1, "data": 4}], HELD, "m at 110 ns: the command changed while waitrequest was 1"),
    *(
        ("wires_axi", [{channel: 1}, {}], HELD, f"m at 110 ns: {channel}: valid fell before ready came")
        for channel in ("aw", "w", "ar")
    ),
    *(
        ("wires_axi", [{channel: 1}, {channel: 1, "address": 4, "data": 4}], HELD,
         f"m at 110 ns: {channel}: the payload changed while valid waited for ready")
        for channel in ("aw", "w", "ar")
    ),
]  # fmt: skip


@pytest.mark.parametrize("top, steps, stall, said", REGISTER_RULES, ids=[f"{r[0]}-{i}" for i, r in enumerate(REGISTER_RULES)])
def test_each_rule_of_a_master_is_named_with_its_time(top, steps, stall, said):
    with pytest.raises(ProtocolError) as caught:
        hoverlock.simulate(Design(WIRES, top=top), break_registers, arguments={"steps": steps, "stall": stall})
    assert str(caught.value) == said


def test_masters_that_keep_the_rules_are_not_complained_of():
    for top, steps in [
        ("wires_mm", [{"read": 1}, {"write": 1}, {}]),
        ("wires_axi", [{"aw": 1, "w": 1}, {"ar": 1}, {}]),
    ]:
        hoverlock.simulate(Design(WIRES, top=top), break_registers, arguments={"steps": steps, "stall": None})


@pytest.mark.parametrize("stall", [0, 1, 4])
def test_an_avalon_master_bursts_of_every_length_wait_and_pause(stall):
    async def bench(dut):
        await reset(dut)
        mem, random, words = AvalonMaster(dut, "mem_", dut.clk), generator(), np.zeros(64, dtype=np.uint64)
        await mem.write_burst(0, words[:15])
        for at in range(15, 64):
            await mem.write(at, 0)
        for length in range(1, 16):
            for pause in (None, 0.5, [1, 1, 0]):
                at = int(random.integers(65 - length))
                words[at : at + length] = random.integers(0, 2**32, length, dtype=np.uint64)
                await mem.write_burst(at, words[at : at + length], pause=pause, seed=length)
                read = await mem.read_burst(at, length)
                assert read.dtype == np.uint64 and np.array_equal(read, words[at : at + length])
        assert [await mem.read(at) for at in range(64)] == words.tolist()
        # Two tasks at once: one burst after the other.
        tasks = [start_soon(mem.read_burst(at, 9)) for at in (3, 40)]
        both = [await task for task in tasks]
        assert np.array_equal(both, [words[3:12], words[40:49]])

    hoverlock.simulate(Design(FOLDER + "burst_ram.v", top="burst_ram", parameters={"STALL": stall}), bench, wall_limit=60)


async def let_burst(dut, count, gap):
    """Lets the design copy a burst of words, adding 1."""
    await reset(dut)
    dut.count.value, dut.gap.value, dut.start.value = count, gap, 1
    await with_timeout(RisingEdge(dut.done), 100, "us")
    await RisingEdge(dut.clk)


@hoverlock.test(design=Design(FOLDER + "burst_copier.v", top="burst_copier"))
@hoverlock.parametrize(count=[1, 2, 15], gap=[0, 3], stall=[None, 0.5, [1, 1, 0]], latency=[(1, 1), (4, 4), (1, 6)])
async def an_avalon_memory_serves_bursts(dut, count, gap, stall, latency):
    memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst, step=4)
    memory.stall(stall, seed=61)
    memory.latency(*latency, seed=62)
    words = generator().integers(0, 2**32, count, dtype=np.uint64)
    memory.write(0x100, words)
    await let_burst(dut, count, gap)
    assert np.array_equal(memory.read(0x200, count + 1), [*((words + 1) & 0xFFFF_FFFF), 0])
    assert memory[0x100 + 4 * (count - 1)] == words[-1] and memory.accesses == 2 * count


# The reset ends after the edge of 30 ns, `start` is seen at 50 ns, the command at 60 ns.
@pytest.mark.parametrize("fault, said", [(1, "m at 60 ns: burstcount is 0"), (2, "a read inside a burst of writes")])
def test_each_rule_of_bursts_is_named(fault, said):
    async def bench(dut):
        memory = AvalonMemory(dut, "m_", dut.clk, reset=dut.rst, step=4)
        await let_burst(dut, 5, 2)
        return memory.accesses

    design = Design(FOLDER + "burst_copier.v", top="burst_copier", parameters={"FAULT": fault})
    with pytest.raises(ProtocolError, match=f"{said}$"):
        hoverlock.simulate(design, bench)


def test_bursts_pause_as_asked_and_impossible_ones_are_refused():
    async def bursts(dut):
        await reset(dut)
        mem = AvalonMaster(dut, "mem_", dut.clk)
        for words in (0, 16):
            said = f"'mem' takes bursts of 1 to 15 words, not {words}"
            with pytest.raises(hoverlock.HoverlockError, match=said):
                await mem.read_burst(0, words)
            with pytest.raises(hoverlock.HoverlockError, match=said):
                await mem.write_burst(0, range(words))
        await mem.write_burst(5, [7, 8])
        assert (await mem.read_burst(5, 2)).tolist() == [7, 8]
        # A word a cycle; with two cycles of pause before each but the first, 2 * 7 more.
        await ClockCycles(dut.clk, 4)
        for pause, cycles in [(None, 8), ([1, 1, 0], 22)]:
            before = hoverlock.get_sim_time("ns")
            await mem.write_burst(0, range(8), pause=pause)
            assert hoverlock.get_sim_time("ns") - before == 10 * cycles

    async def no_bursts(dut):
        await reset(dut)
        with pytest.raises(hoverlock.HoverlockError, match="'csr' has no burstcount: one word at a time"):
            await AvalonMaster(dut, "csr_", dut.clk).write_burst(0, [1, 2])

    hoverlock.simulate(Design(FOLDER + "burst_ram.v", top="burst_ram"), bursts, wall_limit=60)
    hoverlock.simulate(Design(FOLDER + "registers_mm.v", top="registers_mm"), no_bursts, wall_limit=60)


# ---- AXI4


def ram_axi4(**parameters):
    return Design(FOLDER + "ram_axi4.v", top="ram_axi4", parameters=parameters)


@pytest.mark.parametrize("stall", [0, 1])
@pytest.mark.parametrize("pause", [None, 0.5, [1, 0, 0]])
def test_an_axi4_master_bursts(stall, pause):
    async def bench(dut):
        memory, random = AxiMaster(dut, "s_axi_", dut.clk), np.random.default_rng(7)
        memory.pause(pause, seed=3)
        Clock(dut.clk, 10, "ns").start()
        dut.rst.value = 1
        await ClockCycles(dut.clk, 3)
        dut.rst.value = 0
        for address, length in ((0, 1), (0x20, 7), (0x100, 256)):
            words = random.integers(0, 2**32, length)
            await memory.write_burst(address, words)
            assert (await memory.read_burst(address, length) == words).all()
        await memory.write(0x40, 5)
        assert await memory.read(0x40) == 5
        with pytest.raises(hoverlock.HoverlockError, match="cross a multiple of 4 KiB"):
            await memory.read_burst(0xFFC, 2)
        with pytest.raises(hoverlock.RangeError, match="s_axi_wdata"):
            await memory.write(0, 1 << 32)

    hoverlock.simulate(ram_axi4(STALL=stall), bench, wall_limit=60)


@pytest.mark.parametrize(("fault", "rule"), [(1, "rlast is 1 at beat 3 of 4"), (2, "bvalid before"), (4, "payload changed"), (5, "valid fell")])
def test_a_broken_axi4_slave_is_caught(fault, rule):
    async def bench(dut):
        memory = AxiMaster(dut, "s_axi_", dut.clk)
        memory.pause([0, 1, 1])
        Clock(dut.clk, 10, "ns").start()
        dut.rst.value = 1
        await ClockCycles(dut.clk, 3)
        dut.rst.value = 0
        await memory.write_burst(0, range(4))
        await memory.read_burst(0, 4)

    with pytest.raises(ProtocolError, match=rule):
        hoverlock.simulate(ram_axi4(FAULT=fault), bench, wall_limit=60)


# ---- AXI4-Lite


@hoverlock.test(design=registers_axi)
@hoverlock.parametrize(pause=[None, 0.5, [1, 0, 0]])
async def an_axi_lite_master_reaches_registers(dut, pause):
    csr, random, words = AxiLiteMaster(dut, "s_axi_", dut.clk), generator(), [0] * 4
    csr.pause(pause, seed=41)
    await reset(dut)
    for _ in range(100):
        at, word, mask = (int(random.integers(top)) for top in (4, 2**32, 16))
        if random.random() < 0.5:
            await csr.write(4 * at, word, bytes=mask)
            kept = sum(0xFF << (8 * b) for b in range(4) if not mask >> b & 1)
            words[at] = words[at] & kept | word & ~kept & 0xFFFF_FFFF
        assert await csr.read(4 * at) == words[at]
    # Writes and reads of several tasks at once.
    tasks = [start_soon(csr.write(4 * at, at)) for at in range(4)]
    for task in tasks:
        await task
    assert [await csr.read(4 * at) for at in range(4)] == [0, 1, 2, 3]
    with pytest.raises(hoverlock.SimulationError, match="s_axi_: write at 0x10 answered SLVERR"):
        await csr.write(0x10, 1)
    with pytest.raises(hoverlock.SimulationError, match="s_axi_: read at 0x20 answered DECERR"):
        await csr.read(0x20)
    assert await csr.read(4) == 1


@hoverlock.test(design=copier_axi)
@hoverlock.parametrize(stall=[None, 0.5, [1, 1, 0]], count=[1, 40])
async def an_axi_lite_memory_serves_a_master(dut, stall, count):
    memory = AxiLiteMemory(dut, "m_axi_", dut.clk, reset=dut.rst_n, reset_active=False)
    memory.stall(stall, seed=51)
    words = await copy(dut, memory, count)
    assert np.array_equal(memory.read(1024, count), (words + 1) & 0xFFFF_FFFF)
    assert memory[1024] == memory.read(1024, 1)[0] and memory.accesses == 2 * count
    memory[1024] = 5
    assert memory.read(1020, 2).tolist() == [memory[1020], 5]


# ---- whole arrays


@pytest.mark.parametrize("idle", [None, 0.5, [0, 1]])
@pytest.mark.parametrize("stall", [None, 0.5, [1, 0, 1]])
def test_whole_arrays_and_beats_give_the_same(idle, stall):
    frames = np.random.default_rng(61).integers(0, 256, (3, 100), dtype=np.uint8)

    async def by_beats(dut):
        source = AvalonSource(dut, "in_", dut.clk, reset=dut.rst)
        sink = AvalonSink(dut, "out_", dut.clk, reset=dut.rst, symbol_bits=16)
        source.pause(idle, seed=1)
        sink.pause(stall, seed=2)
        await reset(dut)
        for frame in frames:
            source.send(frame)
        return np.concatenate([(await with_timeout(sink.recv(), 1, "ms")).symbols for _ in frames])

    async def by_hand(dut):
        await reset(dut)
        await FallingEdge(dut.clk)
        words, dut.out_ready.value = [], 1
        for frame in frames:
            for at, sample in enumerate(frame):
                dut.in_valid.value, dut.in_data.value = 1, sample
                dut.in_startofpacket.value, dut.in_endofpacket.value = at == 0, at == len(frame) - 1
                await FallingEdge(dut.clk)
                assert dut.out_valid.value
                words.append(int(dut.out_data.value))
        return words

    with Session(stream) as session:
        session.run(reset)
        in_bulk = session.transfer(frames.ravel(), idle=idle, stall=stall, packet=100, seed=9)
    assert np.array_equal(in_bulk, hoverlock.simulate(stream, by_beats))
    if idle is None and stall is None:
        assert in_bulk.tolist() == hoverlock.simulate(stream, by_hand)


@pytest.mark.parametrize("pause, wrong", [(1.0, "probability"), (-0.1, "probability"), ([1, 1], "lets nothing through")])
def test_pauses_that_let_nothing_through_are_refused(pause, wrong):
    async def bench(dut):
        for bus in (AvalonSource(dut, "in_", dut.clk), AvalonSink(dut, "out_", dut.clk)):
            with pytest.raises(ValueError, match=wrong):
                bus.pause(pause)

    hoverlock.simulate(stream, bench)


def test_a_pause_holds_back_as_often_as_it_says():
    async def bench(dut, idle, stall):
        source, sink = AvalonSource(dut, "in_", dut.clk), AvalonSink(dut, "out_", dut.clk, symbol_bits=16)
        source.pause(idle, seed=3)
        sink.pause(stall, seed=4)
        await reset(dut)
        source.send(np.zeros(20000, dtype=np.uint8))
        await ClockCycles(dut.clk, 10000)
        return sink.beats / 10000

    # A pattern is exact but for the few cycles of the start; a probability of p leaves 1 - p, with a standard deviation
    # of sqrt(p (1 - p) / 10000) = 0.0046 for p = 0.3: five of them are allowed.
    for idle, stall, share, within in [
        (None, None, 1.0, 0.001),
        ([1, 0, 0], None, 2 / 3, 0.001),
        (None, [1, 1, 0], 1 / 3, 0.001),
        (0.3, None, 0.7, 0.023),
        (None, 0.3, 0.7, 0.023),
    ]:
        assert abs(hoverlock.simulate(stream, bench, arguments={"idle": idle, "stall": stall}) - share) < within
