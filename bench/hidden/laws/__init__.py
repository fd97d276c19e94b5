"""What can be hidden: the registry, and laws by family; importing a family registers it."""
