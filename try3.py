import numpy as np, math, mjbiped, time
from mjbiped.robots.three_d import *
from mjbiped.gaits import space
sl=math.radians(2)
g0=mjbiped.find_passive_gait(mjbiped.Compass(),sl); st=g0.start; T=g0.period; om=3.84; w=0.1
print(space.find(Compass3D(hip_width=w),sl,np.array([st[0],0.0,st[2],st[3],w*om*math.tanh(om*T/2)/2]))[::2])
sl=math.radians(3); rb=mjbiped.KneedBiped(); g0=mjbiped.find_kneed_gait(rb,slope=sl); st=g0.start; T=g0.period; om=3.3
x,_,mu,_=space.find(Kneed3D(hip_width=w),sl,np.array([st[0],0.0,st[3],st[4],w*om*math.tanh(om*T/2)/2])); print(x,abs(mu))
