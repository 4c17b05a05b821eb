"""Rooms that airside simulates as Gymnasium environments: airside/Rc-v0, airside/EnergyPlus-v0, airside/Site-v0."""

import gymnasium

from .environment import RoomEnvironment
from .failure import AirsideError

__all__ = ["AirsideError", "RoomEnvironment"]

_CLASS = "airside_gym.environment:RoomEnvironment"
gymnasium.register("airside/Rc-v0", _CLASS, kwargs={"plant": "rc"})
gymnasium.register("airside/EnergyPlus-v0", _CLASS, kwargs={"plant": "energyplus"})
gymnasium.register("airside/Site-v0", _CLASS, kwargs={"needs_site": True})
