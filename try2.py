import sys; sys.path.insert(0,'/work/shared/prototypes/threed')
import numpy as np, math, mjbiped, time
from mjbiped.robots.three_d import *
from mjbiped.gaits import space
import compass3d as c3
sl=math.radians(2)
g0=mjbiped.find_passive_gait(mjbiped.Compass(),sl); st=g0.start
for w in (0.02,0.1):
    r=Compass3D(hip_width=w); om=3.84; T=g0.period
    guess=np.array([0.0, st[0], w*om*math.tanh(om*T/2)/2, st[2], st[3]])
    t=time.time(); x,sol,mu,(a,T,e)=space.find(r,sl,guess); print(w,sol.success,abs(sol.fun).max(),x,T,abs(mu),time.time()-t)
    P=c3.params(mjbiped.Compass(),w); s2,_=c3.find_gait(P,sl); print(s2.x, np.sort(abs(c3.multipliers(P,s2.x,sl)))[::-1])
