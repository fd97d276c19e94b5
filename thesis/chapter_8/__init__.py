"""Chapter 8: success over the place of the hand, with objects that stand or lie on a table."""
