"""What RViz and Foxglove show of a simulation: surfaces, contacts and forces."""
