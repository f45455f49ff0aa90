"""Motor commands and how they change in time."""

from glossa.motor.commands import MUSCLES, VOWELS, MotorCommands
from glossa.motor.schedule import Ramp, Schedule

__all__ = ["MUSCLES", "VOWELS", "MotorCommands", "Ramp", "Schedule"]
