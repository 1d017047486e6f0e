"""``cocotb.simtime``, by cocotb 2's name."""

from .utils import get_sim_steps, get_sim_time, get_time_from_sim_steps

__all__ = ["get_sim_steps", "get_sim_time", "get_time_from_sim_steps"]
