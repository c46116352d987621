import sys; sys.path.insert(0,'/work/shared/prototypes/threed')
import numpy as np
from mjbiped.robots.space import *
import compass3d as c3, mjbiped
r=mjbiped.Compass(hip_mass=1.0); P=c3.params(r,0.13); m,mH,a,b,J,Jz,Ip,w,g=P; l=a+b
L=SpatialLinkage(np.array([m,mH,m]),np.array([[a,0],[l,0],[l,-b]]),np.array([0,w/2,w]),np.array([l,-l]),w,np.array([J,J]),np.array([Jz,Jz]),Ip,g)
rng=np.random.default_rng(0); k=[1,2,0]
for _ in range(3):
    p=rng.normal(0,.3,3); dp=rng.normal(0,1,3); M,h,G=c3.terms(P,p,dp); q=p[k]; dq=dp[k]
    print(abs(M[np.ix_(k,k)]-L.mass_matrix(q)).max(),abs(h[k]-L.coriolis_forces(q,dq)).max(),abs(G[k][:,[0,2,1]]-L.gravity_forces(q)).max())
    qn,dn=c3.impact(P,p,dp); qe,de=L.touchdown(q,dq); print(abs(qe-qn[k]).max(), abs(de-dn[k]).max(), abs(L.swing_foot(q)[2]-c3.height(P,p)))
