"""Plan, simulate and evaluate fleets of docked Modboats and ROVs.

Units are SI, angles radians. Results are those of the program `flotilla`, digit for digit. `ValueError` and `TypeError` tell what is wrong
with what was given, `RuntimeError` what could not be done; their messages are those of the program.
"""

from ._flotilla import (
    Envelope,
    Identified,
    Map,
    Plan,
    Planner,
    Plans,
    Reconfiguration,
    Route,
    RovSimulation,
    Run,
    Simulation,
    Transition,
    envelope,
    identify,
    plan,
    reconfigure,
    route,
    run,
    simulate,
    transition,
    vehicle,
)
from ._log import Log, read_log

__all__ = [
    "Envelope",
    "Identified",
    "Log",
    "Map",
    "Plan",
    "Planner",
    "Plans",
    "Reconfiguration",
    "Route",
    "RovSimulation",
    "Run",
    "Simulation",
    "Transition",
    "envelope",
    "identify",
    "plan",
    "read_log",
    "reconfigure",
    "route",
    "run",
    "simulate",
    "transition",
    "vehicle",
]
