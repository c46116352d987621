import numpy as np, math, mjbiped, sys, time, scipy
from try4 import *
from mjbiped.engines.space.footing import *
from mjbiped.robots.space import exchanged
class Plane:
    def __init__(s,slope=0,lat=0): s.a=math.tan(math.radians(slope)); s.b=math.tan(math.radians(lat))
    def height(s,x,y): return -s.a*x-s.b*y
    def normal(s,x,y): n=np.array([s.a,s.b,1.0]); return n/np.linalg.norm(n)
class Steps(Plane):
    def __init__(s,rise,tread=0.8,first=0.6): s.r,s.t,s.f=rise,tread,first
    def height(s,x,y): return s.r*max(0,math.floor((x-s.f)/s.t)+1)
    def normal(s,x,y): return np.array([0,0,1.0])
def walk(c,ground,steps=30,start=None,push=None):
    robot=c.robot; L=robot.in_space[len(robot.angles)-1]; n=len(robot.angles); l=robot.leg_length
    y0=c.gait.start if start is None else start
    x0=np.array([0,0.05,ground.height(0,.05)]); f=first_footing(x0,ground.normal(0,.05))
    q,dq=y0[:n].copy(),y0[n:].copy(); mem=[0.0]*c.memory_size; c.start(mem,q,dq); T=0; rows=[]; work=0; workr=0; pk=np.zeros(3)
    B=robot.input_matrix; W=L.masses.sum()*robot.gravity
    for k in range(steps):
        def rates(t,y):
            m=[*y[2*n:2*n+3],*mem[3:]]; out=np.array(c.torque(m,t,y[:n],y[n:2*n])); pw=abs(out[:3]*robot.joint_rates(y[n:2*n]))
            pk[:]=np.maximum(pk,abs(out[:3]))
            return np.concatenate([y[n:2*n],L.accelerations(B@out[:n],y[:n],y[n:2*n],f.pull),out[n:],[pw[:2].sum(),pw[2]]])
        def gap(t,y):
            p=f.swing_foot(L,y[:n]); ahead=(p-f.place)@f.forward
            return p[2]-ground.height(p[0],p[1]) if ahead>0.2*l and t>0.1 else 0.1
        def fell(t,y): return 1.0-max(abs(y[0]),abs(y[2])*1.5)
        gap.terminal,gap.direction=True,-1; fell.terminal=True
        sol=scipy.integrate.solve_ivp(rates,(0,3.2),np.concatenate([q,dq,mem[:3],[0,0]]),"DOP853",rtol=1e-8,atol=1e-8,max_step=0.02,events=[gap,fell])
        if not sol.t_events[0].size: return 'fell' if sol.t_events[1].size else 'stalled',k,rows,work,workr,pk
        y=sol.y_events[0][0]; work+=y[-2]; workr+=y[-1]; T+=sol.t_events[0][0]; qb=y[:n].copy()
        p=f.swing_foot(L,qb); p[2]=ground.height(p[0],p[1]); new,turn=f.next(p,ground.normal(p[0],p[1]),qb[-1])
        q,dq=L.touchdown(qb,y[n:2*n],turn)
        # roll from the new ground
        axle,up=f.axes(qb[-1]); q[-1]=math.asin(np.clip(-axle@new.normal,-1,1))
        f=new; mem[:3]=y[2*n:2*n+3].tolist(); c.on_touchdown(mem,qb,q,dq); rows.append((T,*q,*dq,*f.place))
    return 'finished',steps,rows,work/(W*rows[-1][-3]),workr/(W*rows[-1][-3]),pk
if __name__=='__main__':
    g=make(); c=SpatialController(g.robot,g)
    for name,gr in dict(level=Plane(),down3=Plane(3),up3=Plane(-3),lat2=Plane(0,2),lat3=Plane(0,3),stepsdown=Steps(-.02),stepsup=Steps(.02)).items():
        t=time.time(); o=walk(c,gr,30); r=np.array(o[2]); print(name,o[0],o[1],'c_mt %.4f + %.4f'%(o[3],o[4]),o[5],'roll',np.degrees(r[:,3].min()),np.degrees(r[:,3].max()),'y',r[-1,-2],round(time.time()-t,1))
