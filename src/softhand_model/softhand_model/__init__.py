"""Physics of pneumatic soft hands: rubber, actuators, chains, gas, hands and the pneumatic plant."""
