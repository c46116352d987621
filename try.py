import sys; sys.path.insert(0,'/work/shared/prototypes/threed')
import numpy as np
from mjbiped.robots.space import *
import compass3d as c3, mjbiped
r=mjbiped.Compass(hip_mass=1.0); P=c3.params(r,0.13); m,mH,a,b,J,Jz,Ip,w,g=P; l=a+b
L=SpatialLinkage(np.array([m,mH,m]),np.array([[a,0],[l,0],[l,-b]]),np.array([0,w/2,w]),np.array([l,-l]),w,np.array([J,J]),np.array([Jz,Jz]),Ip,g)
rng=np.random.default_rng(0)
for _ in range(3):
    q=rng.normal(0,.3,3); dq=rng.normal(0,1,3); M,h,G=c3.terms(P,q,dq)
    print(abs(M-L.mass_matrix(q)).max(),abs(h-L.coriolis_forces(q,dq)).max(),abs(G-L.gravity_forces(q)).max())
    qn,dn=c3.impact(P,q,dq); qe=exchanged(q); print(abs(qe-qn).max(), abs(np.linalg.solve(L.mass_matrix(qe),L.momenta_after_touchdown(q,dq))-dn).max(), abs(L.swing_foot(q)[2]-c3.height(P,q)))
