"""Driver of the pneumatic box: air mass observer, valve control and safety, and its node."""
