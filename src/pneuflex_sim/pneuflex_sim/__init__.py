"""PyBullet simulation of PneuFlex actuators and the RBO Hands."""
