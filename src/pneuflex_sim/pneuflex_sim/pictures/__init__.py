"""Pictures of hands and states: skin, surfaces, renderings, drawings."""
