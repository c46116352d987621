"""Disturbances of a control loop and of a robot: noise, delay, weak motors, pushes."""
