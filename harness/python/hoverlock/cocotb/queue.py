"""``cocotb.queue``."""

from ..queue import LifoQueue, PriorityQueue, Queue, QueueEmpty, QueueFull

__all__ = ["AbstractQueue", "LifoQueue", "PriorityQueue", "Queue", "QueueEmpty", "QueueFull"]

AbstractQueue = Queue
