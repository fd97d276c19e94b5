"""Parts of a hand: rubber, sections, actuators, joints; and the hand's file."""
