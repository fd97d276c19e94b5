"""The simulated chain: segments, joints, their free response and volumes."""
