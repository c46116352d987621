import sys; sys.path.insert(0,'/work/shared/prototypes/threed')
import numpy as np, math, mjbiped
from mjbiped.robots.three_d import *
from mjbiped.robots.space import *
from mjbiped.gaits import space
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.reference import table_of, motion_at
from mjbiped.controllers.space import SpatialController
sl=math.radians(2)
def gait_of(robot, sl, guess):
    x,_,mu,(a,T,e)=space.find(robot,sl,guess)
    L=robot.in_space[2]; pull=pull_of(sl); y=space.start_of(L,x)
    t,_,sol=space.flow(L,pull,y,lambda v:1.0,span=1.6*T)
    N=64; w=T/N
    powers=np.arange(10); v=np.array([0,1/3,2/3,1])[:,None]**powers; d=np.hstack([np.zeros((4,1)),powers[1:]*v[:,:-1]]); dd=np.hstack([np.zeros((4,1)),powers[1:]*d[:,:-1]])
    mat=np.vstack([v,d,dd[::3]])
    count=int(1.5*N); st=sol.sol(w/3*np.arange(3*count+1)).T
    q=st[:,:3]; dq=w*st[:,3:]; ddq=w**2*np.array([L.accelerations(np.zeros(3),s[:3],s[3:],pull) for s in st])
    known=[np.vstack([q[k:k+4],dq[k:k+4],ddq[k:k+4:3]]) for k in range(0,3*count,3)]
    co=np.linalg.solve(mat,np.hstack(known)).reshape(10,count,3).swapaxes(0,1)
    return Gait(robot=robot,slope=sl,start=y,end=e,period=T,step_length=float(L.swing_foot(e[:3])[0]),tables=(table_of(N/T,co),))
g0=mjbiped.find_passive_gait(mjbiped.Compass(),sl); st=g0.start; T=g0.period; om=3.84; W=0.1
def make(w=W):
    r=Compass3D(hip_width=w)
    return gait_of(r,sl,np.array([st[0],0.0,st[2],st[3],w*om*math.tanh(om*T/2)/2]))
if __name__=='__main__':
    g=make(); print(g.period,g.step_length,g.start)
    c=SpatialController(g.robot,g)
    # Lyapunov identity
    rng=np.random.default_rng(0); worst=0; L=g.robot.in_space[2]
    for _ in range(100):
        q=rng.normal(0,.3,3); dq=rng.normal(0,1,3); mem=[0.0]*c.memory_size; c.start(mem,q,dq); true=rng.normal(0,.1,3)+[0,1,0]; mem[:3]=(true+rng.normal(0,.2,3)).tolist(); t=rng.uniform(0,.7)
        tq,tdq,tddq=c.reference(mem,t); z=tq-q; dz=tdq-dq; z2=dz+5*z
        out=np.array(c.torque(mem,t,q,dq)); F=g.robot.input_matrix@out[:3]; dd=L.accelerations(F,q,dq,true); ddz=tddq-dd
        V=z@dz+z2@(ddz+5*dz)+(np.array(mem[:3])-true)@out[3:]/.3
        worst=max(worst,abs(V+5*z@z+12*z2@z2)/(1+abs(V)))
    print('lyapunov',worst)
