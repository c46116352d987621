"""A controller of your own, a spring at the hip, walks down a gentle slope."""

import math

import mjbiped
from controllers import Controller


class HipSpring(Controller):
    def torque(self, memory, t, q, dq):
        return 0.0, -2.0 * (q[1] - q[0])  # ankle and hip, N m


robot = mjbiped.Compass()
start = mjbiped.find_passive_gait(robot, slope=math.radians(2)).start
walk = mjbiped.walk(HipSpring(), mjbiped.Terrain.incline(2.0), steps=20, initial=start)
walk.plot("own_controller.png", panels=("phase", "torque"))
