"""Plan, simulate and evaluate fleets of docked Modboats and ROVs.

Units are SI, angles radians. Results are those of the program `flotilla`, digit for digit.
"""

from ._flotilla import Plan, plan

__all__ = ["Plan", "plan"]
