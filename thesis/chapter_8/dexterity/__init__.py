"""What the hand can do with its own fingers: postures, and the judges of what they touch."""
