"""How many steps the robot walks on rough ground before a fall, with intervals, from forty walks."""

import math

import mjbiped
from controllers import AdaptiveController
from mjbiped.plotting.survival import plot_survival

robot = mjbiped.Compass()
law = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=math.radians(2)))
survivals = {}
for millimetres in (30, 45, 60):
    terrains = [mjbiped.Terrain.treads(seed=seed, deviation=millimetres / 1000) for seed in range(40)]
    walks = mjbiped.walk_many(law, terrains, engine="hybrid", steps=60)
    survivals[f"steps of {millimetres} mm"] = mjbiped.Survival.of(walks)
plot_survival(survivals, "survival.png")
