import numpy as np, math, mjbiped, time
from mjbiped.robots.three_d import *
from mjbiped.gaits import space
sl=math.radians(3)
rb=mjbiped.KneedBiped()
g0=mjbiped.find_kneed_gait(rb,slope=sl); st=g0.start; print(st,g0.period, abs(g0.multipliers))
x=None
for w in (1e-6,0.02,0.05,0.1):
    r=Kneed3D(hip_width=w); om=3.3; T=g0.period
    guess=np.array([0.0, st[0], w*om*math.tanh(om*T/2)/2, st[3], st[4]]) if x is None else np.array([x[0]*w/wl, x[1], x[2]*w/wl, x[3], x[4]])
    x,sol,mu,(a,T,e)=space.find(r,sl,guess); wl=w; print(w,sol.success,abs(sol.fun).max(),x,T,abs(mu))
