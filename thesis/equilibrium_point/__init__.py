"""Section 4.2: equilibrium-point control, and the response of a pressed finger to each
controller.
"""

STYLE = {"savefig.dpi": 110}
