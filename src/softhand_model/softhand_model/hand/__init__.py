"""What a hand is made of: rubber, sections, actuators, joints and the hand's file."""
