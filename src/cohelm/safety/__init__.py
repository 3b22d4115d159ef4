"""Safety gate: the last stage before the wheels."""

from cohelm.safety.gate import GateParameters, gate, stop
from cohelm.safety.input_check import GateState, check_input

__all__ = ["GateParameters", "GateState", "check_input", "gate", "stop"]
