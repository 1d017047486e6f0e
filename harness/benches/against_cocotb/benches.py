"""The benches of the comparison, one source for all: only the imports differ.

Those on `stream.v` take the sum of what they saw in the first CHECK cycles and then measure CPU time over the rest; `frames` runs
on the Hoverlock top and takes all records. What was seen must be equal everywhere.
"""

import json
import os
import time
import zlib

if os.environ["BENCH_WITH"] == "hoverlock":
    import hoverlock.cocotb as cocotb
    from hoverlock.cocotb.clock import Clock
    from hoverlock.cocotb.triggers import ClockCycles, RisingEdge
else:
    import cocotb
    from cocotb.clock import Clock
    from cocotb.triggers import ClockCycles, RisingEdge

CHECK = 4000
CYCLES = int(os.environ["BENCH_CYCLES"])


def report(name, cycles, seconds, check):
    with open(os.environ["BENCH_OUT"], "a", encoding="utf-8") as out:
        out.write(json.dumps({"name": name, "cycles": cycles, "seconds": seconds, "check": check}) + "\n")


# cocotb 2 has a clock that is driven without Python.
CLOCK = {"impl": "gpi"} if os.environ["BENCH_WITH"] == "cocotb 2" else {}


async def begin(dut):
    cocotb.start_soon(Clock(dut.clk, 10, "ns", **CLOCK).start())
    for signal in (dut.in_valid, dut.in_data, dut.in_startofpacket, dut.in_endofpacket):
        signal.value = 0
    dut.out_ready.value = 1
    dut.rst.value = 1
    await ClockCycles(dut.clk, 4)
    dut.rst.value = 0
    # The recursion starts afresh: Icarus knows X, Verilator does not.
    dut.in_startofpacket.value = 1
    dut.in_valid.value = 1
    await RisingEdge(dut.clk)
    dut.in_startofpacket.value = 0
    await RisingEdge(dut.clk)
    await RisingEdge(dut.clk)


@cocotb.test()
async def per_cycle(dut):
    """Each cycle: await the edge, read one, write one."""
    await begin(dut)
    edge, data, out = RisingEdge(dut.clk), dut.in_data, dut.out_data

    async def cycles(count, total):
        for i in range(count):
            await edge
            total += int(out.value)
            data.value = i & 255
        return total

    check = await cycles(CHECK, 0)
    started = time.process_time()
    await cycles(CYCLES, 0)
    report("per_cycle", CYCLES, time.process_time() - started, check)


@cocotb.test()
async def per_cycle_by_name(dut):
    """The same as most benches are written: triggers and handles by name in the loop."""
    await begin(dut)

    async def cycles(count, total):
        for i in range(count):
            await RisingEdge(dut.clk)
            total += int(dut.out_data.value)
            dut.in_data.value = i & 255
        return total

    check = await cycles(CHECK, 0)
    started = time.process_time()
    await cycles(CYCLES, 0)
    report("per_cycle_by_name", CYCLES, time.process_time() - started, check)


@cocotb.test()
async def driver_and_monitor(dut):
    """Two tasks: one writes each cycle, one checks in each cycle whether a beat moves."""
    await begin(dut)
    edge = RisingEdge(dut.clk)

    async def drive(count):
        data = dut.in_data
        for i in range(count):
            await edge
            data.value = i & 255

    async def watch(count):
        valid, ready, out = dut.out_valid, dut.out_ready, dut.out_data
        total = 0
        for _ in range(count):
            await edge
            if int(valid.value) and int(ready.value):
                total += int(out.value)
        return total

    async def both(count):
        driver = cocotb.start_soon(drive(count))
        watcher = cocotb.start_soon(watch(count))
        await driver
        return await watcher

    check = await both(CHECK)
    started = time.process_time()
    await both(CYCLES)
    report("driver_and_monitor", CYCLES, time.process_time() - started, check)


@cocotb.test()
async def source_and_sink(dut):
    """A source that keeps valid and ready, a sink that is not ready one cycle in four."""
    await begin(dut)
    edge = RisingEdge(dut.clk)

    async def source(count):
        data, ready, last = dut.in_data, dut.in_ready, dut.in_endofpacket
        for i in range(count):
            data.value = i & 255
            last.value = i & 255 == 255
            await edge
            while not int(ready.value):
                await edge

    async def sink(count):
        valid, ready, out = dut.out_valid, dut.out_ready, dut.out_data
        received, cycle, open_now = [], 0, 1
        while len(received) < count:
            await edge
            if open_now and int(valid.value):
                received.append(int(out.value))
            cycle += 1
            open_now = 0 if cycle & 3 == 3 else 1
            ready.value = open_now
        return sum(received)

    async def both(words):
        sending = cocotb.start_soon(source(words))
        receiving = cocotb.start_soon(sink(words))
        await sending
        return await receiving

    words = CYCLES * 3 // 4
    check = await both(CHECK)
    started = time.process_time()
    await both(words)
    report("source_and_sink", words * 4 // 3, time.process_time() - started, check)


@cocotb.test()
async def clock_only(dut):
    """Nothing but the clock."""
    await begin(dut)
    await ClockCycles(dut.clk, CHECK)
    check = int(dut.out_data.value)
    started = time.process_time()
    await ClockCycles(dut.clk, CYCLES)
    report("clock_only", CYCLES, time.process_time() - started, check)


def pixel(x, y):
    """As in `limit_top.cpp`."""
    mask = 0xFFFFFFFF
    h = ((x // 8) * 374761393 + (y // 8) * 668265263) & mask
    h = ((h ^ (h >> 13)) * 1274126177) & mask
    return (h ^ (h >> 16)) & 0xFFFF


SIDE = 64


@cocotb.test()
async def frames(dut):
    """On the Hoverlock top, one coroutine a cycle: pixels by hand, records by hand."""
    cocotb.start_soon(Clock(dut.clock, 10, "ns", **CLOCK).start())
    edge = RisingEdge(dut.clock)
    dut.reset.value = 1
    for name in ("video_valid", "video_data", "video_startofpacket", "video_endofpacket", "feature_ready", "csr_read"):
        getattr(dut, name).value = 0
    for name in ("csr_address", "csr_write", "csr_writedata"):
        getattr(dut, name).value = 0
    await ClockCycles(dut.clock, 4)
    dut.reset.value = 0
    await edge
    dut.csr_write.value = 1
    for address, word in ((0x14, SIDE | SIDE << 16), (0x30, 1), (0x0C, 1)):
        dut.csr_address.value = address >> 2
        dut.csr_writedata.value = word
        await edge
    dut.csr_write.value = 0
    dut.feature_ready.value = 1

    frame = [pixel(i % SIDE, i // SIDE) for i in range(SIDE * SIDE)]
    valid, ready, data = dut.video_valid, dut.video_ready, dut.video_data
    first, last = dut.video_startofpacket, dut.video_endofpacket
    given, end, feature = dut.feature_valid, dut.feature_endofpacket, dut.feature_data
    wanted = max(1, CYCLES // (2 * SIDE * SIDE))
    records, sent, packets, cycles, offered, place = [], 0, 0, 0, 0, 0
    started = time.process_time()
    while packets < wanted:
        await edge
        cycles += 1
        if offered and int(ready.value):
            sent += 1
            place = place + 1 if place + 1 < len(frame) else 0
        if int(given.value):
            records.append(int(feature.value))
            packets += int(end.value)
        if sent < wanted * len(frame):
            if not offered:
                offered = 1
                valid.value = 1
            data.value = frame[place]
            first.value = place == 0
            last.value = place + 1 == len(frame)
        elif offered:
            offered = 0
            valid.value = 0
    seconds = time.process_time() - started
    whole = b"".join(record.to_bytes(32, "little") for record in records)
    # The first frame and its trailer: how many follow differs with the time a contestant is given.
    report("frames", cycles, seconds, zlib.crc32(whole[: len(whole) // wanted]))
