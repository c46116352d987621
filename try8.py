import numpy as np, math, mjbiped, time, dataclasses
from try4 import *
g=make(); c=SpatialController(g.robot,g)
T=mjbiped.Terrain
for name,t in dict(level=T.level(),lat3=dataclasses.replace(T.level(),lateral=math.radians(3)),stairs=T.stairs(tread=.8,rise=.02,first=.6)).items():
    s=time.time(); w=mjbiped.walk(c,t,engine="mujoco",steps=12,sample_period=0.01); print(name,w,w.cost_of_transport,w.peak_torque,w.touchdowns["y"][-3:],np.degrees(w.touchdowns["lateral_estimate"][-1]),np.degrees(w.touchdowns["lateral_slope"][-1]),w.touchdowns["normal_force"].min(),w.touchdowns["friction"].max(),'yaw',np.degrees(w.touchdowns["qpos"][:,-1]).max(),round(time.time()-s,1),flush=True)
