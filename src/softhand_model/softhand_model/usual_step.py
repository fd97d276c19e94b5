"""The default step of the physics in trials, strategies, nodes and environments.

Outcomes and motion at other steps: docs/understand/simulator-steps.md.
"""

USUAL_STEP = 0.002  # [s]
