"""Physics of pneumatic soft hands: rubber, actuators, chains, gas, hands, pneumatic plant."""
