"""The passive gait of the paper's robot on a slope of 2 degrees: postures, limit cycle, Floquet multipliers."""

import math

import mjbiped
from mjbiped.plotting.gait import plot_gait

gait = mjbiped.find_passive_gait(mjbiped.Compass(), slope=math.radians(2))
print(gait.period, gait.step_length, abs(gait.multipliers))
plot_gait(gait, "gait.png")
