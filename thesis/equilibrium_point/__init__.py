"""Section 4.2: equilibrium-point control, what a push on a finger does under each controller."""

STYLE = {"savefig.dpi": 110}
