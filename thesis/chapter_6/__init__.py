"""Chapter 6: principles of soft manipulation, measured."""
