"""The step of the physics that trials, strategies, nodes and environments take without being told.

Outcomes and motion at other steps: docs/understand/simulator-steps.md.
"""

USUAL_STEP = 0.002  # [s]
