"""Static equilibrium of chains, without a time step: in the plane and in space."""
