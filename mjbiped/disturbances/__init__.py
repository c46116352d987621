"""What the real world does to a control loop and to a robot: noise, delay, weak motors, pushes."""
