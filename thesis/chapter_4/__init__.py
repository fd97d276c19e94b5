"""Chapter 4: the driver on the pretended bench."""
