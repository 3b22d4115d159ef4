"""The safety gate: the last stage before the wheels."""

from cohelm.safety.gate import GateParameters, GateState, check_input, gate, stop

__all__ = ["GateParameters", "GateState", "check_input", "gate", "stop"]
