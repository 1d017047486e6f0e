"""Queues between tasks.

>>> queue = Queue(maxsize=4)
>>> await queue.put(3)
>>> value = await queue.get()
"""

from __future__ import annotations

import heapq
from collections import deque
from typing import Generic, TypeVar

from .triggers import Event

__all__ = ["LifoQueue", "PriorityQueue", "Queue", "QueueEmpty", "QueueFull"]

T = TypeVar("T")


class QueueEmpty(Exception):
    """Raised by ``get_nowait`` on an empty queue."""


class QueueFull(Exception):
    """Raised by ``put_nowait`` on a full queue."""


class Queue(Generic[T]):
    """A first-in, first-out queue of at most ``maxsize`` items; 0 is no limit.

    >>> queue: Queue[int] = Queue(maxsize=4)
    >>> await queue.put(3)
    >>> assert await queue.get() == 3
    """

    def __init__(self, maxsize: int = 0) -> None:
        self.maxsize = maxsize
        self._items: deque[T] | list[T] = self._make()
        # The waiting tasks, the longest wait first. Each has its own event, so that one item wakes one task.
        self._getters: deque[Event] = deque()
        self._putters: deque[Event] = deque()
        self._unfinished = 0
        self._finished = Event("all items done")

    def _make(self) -> deque[T] | list[T]:
        return deque()

    def _put(self, item: T) -> None:
        self._items.append(item)

    def _get(self) -> T:
        return self._items.popleft()  # type: ignore[union-attr]

    def qsize(self) -> int:
        """Returns the number of items."""
        return len(self._items)

    def empty(self) -> bool:
        """Returns whether the queue is empty."""
        return not self._items

    def full(self) -> bool:
        """Returns whether the queue is full."""
        return 0 < self.maxsize <= len(self._items)

    def put_nowait(self, item: T) -> None:
        """Puts an item, or raises ``QueueFull``."""
        # Without a call of `full` and `_wake`: package models of buses pass every beat through a queue.
        if 0 < self.maxsize <= len(self._items):
            raise QueueFull(f"the queue has {self.maxsize} items, which is its limit")
        self._put(item)
        if self._unfinished == 0:
            self._finished = Event("all items done")
        self._unfinished += 1
        if self._getters:
            self._getters.popleft().set()

    def get_nowait(self) -> T:
        """Takes an item, or raises ``QueueEmpty``."""
        if not self._items:
            raise QueueEmpty("the queue is empty")
        item = self._get()
        if self._putters:
            self._putters.popleft().set()
        return item

    def task_done(self) -> None:
        """Reports that an item from ``get`` has been processed."""
        if self._unfinished == 0:
            raise ValueError("task_done was called more often than items were put")
        self._unfinished -= 1
        if self._unfinished == 0:
            self._finished.set()

    async def join(self) -> None:
        """Waits until ``task_done`` was called for each item that was put."""
        if self._unfinished:
            await self._finished.wait()

    async def put(self, item: T) -> None:
        """Puts an item; waits while the queue is full."""
        while self.full():
            await _sleep(self._putters, "queue not full")
        self.put_nowait(item)

    async def get(self) -> T:
        """Takes an item; waits while the queue is empty."""
        while not self._items:
            await _sleep(self._getters, "queue not empty")
        return self.get_nowait()


async def _sleep(waiting: deque[Event], name: str) -> None:
    event = Event(name)
    waiting.append(event)
    try:
        await event.wait()
    except BaseException:
        # The task was cancelled, with an exception of asyncio or without one: the next task is woken instead.
        if event.is_set():
            _wake(waiting)
        else:
            waiting.remove(event)
        raise


def _wake(waiting: deque[Event]) -> None:
    if waiting:
        waiting.popleft().set()


class PriorityQueue(Queue[T]):
    """A queue that returns the smallest item first.

    >>> queue = PriorityQueue()
    >>> queue.put_nowait((2, "later"))
    """

    def _make(self) -> list[T]:
        return []

    def _put(self, item: T) -> None:
        heapq.heappush(self._items, item)  # type: ignore[type-var, arg-type]

    def _get(self) -> T:
        return heapq.heappop(self._items)  # type: ignore[type-var, arg-type]


class LifoQueue(Queue[T]):
    """A last-in, first-out queue.

    >>> stack = LifoQueue()
    >>> stack.put_nowait(1)
    """

    def _get(self) -> T:
        return self._items.pop()
