"""Static equilibrium of chains in space, without a time step."""
