"""Each trigger, alone and combined."""

import gc
import resource
import weakref

import pytest

import hoverlock
from hoverlock import (
    CancelledError,
    Clock,
    ClockCycles,
    Combine,
    Design,
    Edge,
    Event,
    FallingEdge,
    First,
    LifoQueue,
    Lock,
    NextTimeStep,
    NullTrigger,
    PriorityQueue,
    Queue,
    QueueEmpty,
    QueueFull,
    ReadOnly,
    ReadWrite,
    RisingEdge,
    SimTimeoutError,
    Timer,
    ValueChange,
    get_sim_time,
    start,
    start_soon,
    with_timeout,
)

design = Design("designs/counter.v", top="counter")


async def begin(dut, step=1):
    clock = Clock(dut.clk, 10, "ns").start()
    dut.enable.value = 1
    dut.step.value = step
    return clock


@hoverlock.test()
async def edges_come_every_period(dut):
    await begin(dut)
    await RisingEdge(dut.clk)
    start_at = get_sim_time("ns")
    await RisingEdge(dut.clk)
    assert get_sim_time("ns") == start_at + 10
    await FallingEdge(dut.clk)
    assert get_sim_time("ns") == start_at + 15
    await dut.clk.rising_edge
    await Edge(dut.clk)
    assert get_sim_time("ns") == start_at + 25


@hoverlock.test()
async def an_edge_trigger_is_one_object_for_a_signal(dut):
    assert RisingEdge(dut.clk) is RisingEdge(dut.clk)
    assert RisingEdge(dut.clk) is not FallingEdge(dut.clk)
    assert isinstance(RisingEdge(dut.clk), RisingEdge)
    with pytest.raises(TypeError, match="has 8: use ValueChange"):
        RisingEdge(dut.count)


@hoverlock.test()
async def value_change_sees_an_output_change(dut):
    await begin(dut, step=3)
    await ValueChange(dut.count)
    first = int(dut.count.value)
    await ValueChange(dut.count)
    assert int(dut.count.value) == first + 3


@hoverlock.test()
async def clock_cycles_counts_edges(dut):
    await begin(dut)
    await RisingEdge(dut.clk)
    at = get_sim_time("ns")
    await ClockCycles(dut.clk, 7)
    assert get_sim_time("ns") == at + 70
    await ClockCycles(dut.clk, 2, rising=False)
    assert get_sim_time("ns") == at + 85
    await ClockCycles(dut.clk, 0)
    assert get_sim_time("ns") == at + 85
    await ClockCycles(dut.clk, 4, ValueChange)
    assert get_sim_time("ns") == at + 105
    await ClockCycles(dut.clk, 1, edge_type=RisingEdge)
    assert get_sim_time("ns") == at + 110
    with pytest.raises(TypeError, match="'count' has 8: use ValueChange"):
        ClockCycles(dut.count, 1)
    with pytest.raises(TypeError, match="not both"):
        ClockCycles(dut.clk, 1, RisingEdge, rising=True)
    with pytest.raises(TypeError, match="RisingEdge, FallingEdge or ValueChange"):
        ClockCycles(dut.clk, 1, Timer)


@hoverlock.test()
async def timers_are_exact_in_every_unit(dut):
    for time, unit, femtoseconds in [(3, "fs", 3), (2, "ps", 2000), (1.5, "ns", 1500000), (2, "us", 2 * 10**9), (7, "step", 7000)]:
        before = get_sim_time("fs")
        await Timer(time, unit)
        assert get_sim_time("fs") - before == femtoseconds
    before = get_sim_time("fs")
    await Timer(4, units="ns")
    assert get_sim_time("fs") - before == 4 * 10**6
    for bad in [(0, "ns"), (0.5, "fs"), (-1, "ns"), (1, "parsec")]:
        with pytest.raises((ValueError, OverflowError)):
            Timer(*bad)


@hoverlock.test()
async def read_only_sees_settled_values_and_takes_no_write(dut):
    await begin(dut, step=5)
    await RisingEdge(dut.clk)
    before = int(dut.count.value)
    await ReadOnly()
    assert int(dut.count.value) == before + 5
    with pytest.raises(hoverlock.ReadOnlyError, match="'step' was written in ReadOnly"):
        dut.step.value = 1
    with pytest.raises(hoverlock.TriggerError, match="in ReadOnly already"):
        await ReadOnly()
    await NextTimeStep()
    dut.step.value = 1


@hoverlock.test()
async def read_write_sees_settled_values_and_writes(dut):
    await begin(dut, step=5)
    await RisingEdge(dut.clk)
    before = int(dut.count.value)
    await ReadWrite()
    assert int(dut.count.value) == before + 5
    dut.step.value = 9
    await RisingEdge(dut.clk)
    await ReadOnly()
    assert int(dut.count.value) == before + 14


@hoverlock.test()
async def a_register_shows_its_old_value_at_the_edge(dut):
    await begin(dut)
    for expected in range(5):
        await RisingEdge(dut.clk)
        assert int(dut.count.value) == expected


@hoverlock.test()
async def what_is_written_after_an_edge_is_sampled_at_the_next(dut):
    await begin(dut, step=0)
    await RisingEdge(dut.clk)
    dut.step.value = 7
    await RisingEdge(dut.clk)
    assert int(dut.count.value) == 0
    await RisingEdge(dut.clk)
    assert int(dut.count.value) == 7


@hoverlock.test()
async def next_time_step_is_the_next_event(dut):
    await begin(dut)
    await RisingEdge(dut.clk)
    at = get_sim_time("ns")
    await NextTimeStep()
    assert get_sim_time("ns") == at + 5


@hoverlock.test()
async def first_gives_the_trigger_that_came(dut):
    await begin(dut)
    await RisingEdge(dut.clk)
    rising, timer = RisingEdge(dut.clk), Timer(3, "ns")
    assert await First(rising, timer) is timer
    assert await First(rising, Timer(1, "us")) is rising

    async def answer():
        await Timer(1, "ns")
        return (4, 2)

    assert await First(Timer(1, "us"), answer()) == (4, 2)
    assert await First(Timer(1, "us"), First(start_soon(answer()), Timer(2, "us"))) == (4, 2)
    with pytest.raises(ValueError):
        First()
    with pytest.raises(TypeError, match="neither a trigger nor a task"):
        First(3)


@hoverlock.test()
async def combine_waits_for_all(dut):
    await begin(dut)
    before = get_sim_time("ns")
    await Combine(Timer(3, "ns"), Timer(11, "ns"), Timer(7, "ns"))
    assert get_sim_time("ns") == before + 11


@hoverlock.test()
async def one_trigger_serves_many_tasks(dut):
    await begin(dut)
    edge, times = RisingEdge(dut.clk), []

    async def wait(count):
        for _ in range(count):
            await edge
        times.append((count, get_sim_time("ns")))

    await Combine(*[start_soon(wait(n)) for n in (1, 2, 3)])
    assert [n for n, _ in times] == [1, 2, 3]
    assert times[2][1] == times[0][1] + 20


@hoverlock.test()
async def events_wake_all_and_stay_set(dut):
    event, woken = Event("go"), []

    async def wait(name):
        await event.wait()
        woken.append(name)

    for name in "abc":
        start_soon(wait(name))
    await Timer(1, "ns")
    assert woken == [] and not event.is_set()
    event.set(data=17)
    await Timer(1, "ns")
    assert woken == ["a", "b", "c"] and event.data == 17
    before = get_sim_time("fs")
    await event.wait()
    assert get_sim_time("fs") == before
    event.clear()
    assert not event.is_set()


@hoverlock.test()
async def a_lock_goes_round_in_order(dut):
    lock, order = Lock(), []

    async def use(name):
        async with lock:
            order.append(name)
            await Timer(2, "ns")

    await Combine(*[start_soon(use(n)) for n in "abcd"])
    assert order == list("abcd") and not lock.locked()
    with pytest.raises(hoverlock.TriggerError, match="no task holds it"):
        lock.release()
    await lock.acquire()
    assert lock.locked()
    lock.release()


@hoverlock.test()
async def a_queue_holds_back_and_keeps_order(dut):
    queue, got = Queue(maxsize=2), []

    async def produce():
        for item in range(6):
            await queue.put(item)

    async def consume():
        for _ in range(6):
            got.append(await queue.get())
            await Timer(1, "ns")

    await Combine(start_soon(produce()), start_soon(consume()))
    assert got == list(range(6)) and queue.empty()
    queue.put_nowait(1)
    queue.put_nowait(2)
    with pytest.raises(QueueFull):
        queue.put_nowait(3)
    assert (queue.qsize(), queue.full()) == (2, True)
    assert (queue.get_nowait(), queue.get_nowait()) == (1, 2)
    with pytest.raises(QueueEmpty):
        queue.get_nowait()


@hoverlock.test()
async def an_item_reaches_another_when_its_taker_was_cancelled(dut):
    queue, got = Queue(), []

    async def take(name):
        got.append((name, await queue.get()))

    first, _second = start_soon(take("first")), start_soon(take("second"))
    await Timer(1, "ns")
    first.cancel()
    queue.put_nowait("x")
    await Timer(1, "ns")
    assert got == [("second", "x")]


@hoverlock.test()
async def other_queues_order_otherwise(dut):
    least, last = PriorityQueue(), LifoQueue()
    for item in (3, 1, 2):
        await least.put(item)
        await last.put(item)
    assert [await least.get() for _ in range(3)] == [1, 2, 3]
    assert [await last.get() for _ in range(3)] == [2, 1, 3]


@hoverlock.test()
async def with_timeout_gives_the_result_or_raises(dut):
    async def slow():
        await Timer(10, "ns")
        return 5

    assert await with_timeout(slow(), 20, "ns") == 5
    before = get_sim_time("ns")
    with pytest.raises(SimTimeoutError, match="within 4 ns"):
        await with_timeout(slow(), 4, "ns")
    assert get_sim_time("ns") == before + 4
    assert await with_timeout(Timer(1, "ns"), 2, "ns") is None
    assert await with_timeout(Combine(Timer(1, "ns"), Timer(1, "ns")), 2, "ns") is None
    soon = Timer(1, "ns")
    assert await with_timeout(First(soon, Timer(1, "us")), 1, "ms") is soon
    for wait in (start_soon(slow()), start_soon(slow()).join(), First(start_soon(slow()), Timer(1, "us"))):
        assert await with_timeout(wait, 1, "us") == 5


@hoverlock.test()
async def a_coroutine_ends_with_the_task_that_limits_its_time(dut):
    ended = []

    async def slow():
        try:
            await Timer(1, "us")
        finally:
            ended.append(get_sim_time("ns"))

    with pytest.raises(SimTimeoutError, match="within 4 ns"):
        await with_timeout(with_timeout(slow(), 1, "ms"), 4, "ns")
    assert ended == [4]


@hoverlock.test()
async def tasks_give_results_and_exceptions(dut):
    async def add(a, b):
        await Timer(1, "ns")
        return a + b

    async def fail():
        await Timer(1, "ns")
        raise KeyError("lost")

    task = start_soon(add(1, 2))
    assert not task.done()
    assert await task == 3 and task.done() and task.result() == 3 and task.exception() is None
    assert await task.join() == 3  # long since done: at once
    bad = start_soon(fail())
    with pytest.raises(KeyError, match="lost") as caught:
        await bad
    assert "fail" in [entry.name for entry in caught.traceback]
    assert isinstance(bad.exception(), KeyError)


@hoverlock.test()
async def a_cancelled_task_runs_its_finally(dut):
    seen = []

    async def forever():
        try:
            await Timer(1, "ms")
        finally:
            seen.append("closed")

    task = start_soon(forever())
    await Timer(1, "ns")
    assert task.cancel() and seen == ["closed"] and task.cancelled()
    assert not task.cancel()
    with pytest.raises(CancelledError):
        await task
    with pytest.raises(CancelledError):
        task.result()


@hoverlock.test()
async def start_runs_to_the_first_wait_and_start_soon_does_not(dut):
    seen = []

    async def note(what):
        seen.append(what)
        await Timer(1, "ns")

    start_soon(note("soon"))
    assert seen == []
    await start(note("now"))
    assert seen == ["soon", "now"]
    await NullTrigger()
    with pytest.raises(TypeError, match=r"call it, start_soon\(f\(\)\)"):
        start_soon(note)


@hoverlock.test()
async def ended_tasks_are_forgotten(dut):
    async def short():
        await NullTrigger()

    async def many(count):
        for _ in range(count):
            await start_soon(short())

    await many(1000)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    await many(50_000)
    # If ended tasks were kept, each would take about 200 bytes: 10 MB.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 3000


@hoverlock.test()
async def a_generator_may_yield_triggers_itself(dut):
    class Twice:
        def __await__(self):
            yield Timer(1, "ns")
            yield Timer(2, "ns")
            return "both"

    before = get_sim_time("ns")
    assert await Twice() == "both"
    assert get_sim_time("ns") == before + 3


@hoverlock.test()
async def a_wait_may_be_made_by_hand(dut):
    """What `await` does through slots, `__await__` and `next` do as methods."""
    await begin(dut)
    edge = RisingEdge(dut.clk)
    wait = edge.__await__()
    assert next(wait) is edge
    with pytest.raises(StopIteration):
        next(wait)
    assert next(iter(edge)) is edge


@hoverlock.test()
async def an_event_keeps_its_data_and_lets_it_go(dut):
    class Numbered(Event):
        def __init__(self, number, *, name):
            super().__init__(name)
            self.number = number

    event = Numbered(3, name="third")
    assert event.data is None and repr(event) == "<Event 'third' not set>"
    event.set({"of": event})
    assert event.data["of"].number == 3 and event.is_set()
    gone = weakref.ref(event)
    del event
    gc.collect()
    assert gone() is None
    event = Event()
    event.set(5)
    event.set()
    assert event.data is None
    event.data = 6
    event.clear()
    assert event.data == 6


@hoverlock.test()
async def several_clocks_keep_their_phases(dut):
    # `enable` serves as a second clock input here.
    Clock(dut.clk, 10, "ns").start(phase=(3, "ns"))
    Clock(dut.enable, 4, "ns", high=1).start()
    times = []
    for trigger in (RisingEdge(dut.clk), RisingEdge(dut.enable), FallingEdge(dut.enable), RisingEdge(dut.clk)):
        await trigger
        times.append(get_sim_time("ns"))
    assert times == [3, 4, 5, 13]


@hoverlock.test()
async def a_stopped_clock_stands(dut):
    clock = await begin(dut)
    await ClockCycles(dut.clk, 3)
    clock.stop()
    assert clock.done()
    with pytest.raises(SimTimeoutError):
        await with_timeout(RisingEdge(dut.clk), 1, "us")


@hoverlock.test(expect_fail=True)
async def a_failed_assertion_is_expected(dut):
    assert int(dut.count.value) == 1


@hoverlock.test(expect_error=ZeroDivisionError)
async def an_error_is_expected(dut):
    await Timer(1, "ns")
    raise ZeroDivisionError


@hoverlock.test(skip="to be seen as skipped")
async def skipped(dut):
    raise AssertionError


@hoverlock.test()
async def passes_at_once(dut):
    hoverlock.pass_test("enough")
    raise AssertionError


@hoverlock.test()
@hoverlock.parametrize((("a", "b"), [(1, 2), (2, 4)]), c=[3, 5])
async def parameters_combine(dut, a, b, c):
    assert b == 2 * a and c in (3, 5)
