import numpy as np, math, mujoco, sys, time
from try5 import *
def mjcf(robot,h,ground,torsion=0.05,mu=.8):
    l,w=robot.leg_length,robot.hip_width; J,m,mH=robot.leg_inertia,robot.leg_mass,max(robot.hip_mass,1e-4); ip=max(robot.hip_mass*w*w/12,1e-8)
    def leg(n,y,bit): return f'''<body name="{n}" pos="0 {y} 0"><joint name="{n}" type="hinge" axis="0 1 0"/><inertial pos="0 0 {-robot.upper_length}" mass="{m}" diaginertia="{J} {J} {robot.axial_inertia}"/>
     <geom name="{n}_foot" type="sphere" size="5e-5" pos="0 0 {-l}" mass="0" contype="{bit}" conaffinity="0" condim="4" priority="1" friction="{mu} {torsion} 0" solref="-1e3 {-1/h}" solimp="0.9999 0.9999 0.001"/></body>'''
    return f'''<mujoco><compiler angle="radian"/><option timestep="{h}" integrator="Euler" cone="elliptic" gravity="0 0 {-robot.gravity}"><flag eulerdamp="disable" island="disable"/></option>
    <worldbody>{ground.geoms()}<body name="pelvis"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/><joint name="z" type="slide" axis="0 0 1"/><joint name="yaw" type="hinge" axis="0 0 1"/><joint name="roll" type="hinge" axis="1 0 0"/>
    <inertial pos="0 0 0" mass="{mH}" diaginertia="{ip} {ip} {ip}"/>{leg("left",w/2,1)}{leg("right",-w/2,2)}</body></worldbody>
    <tendon><fixed name="hip"><joint joint="right" coef="1"/><joint joint="left" coef="-1"/></fixed></tendon>
    <actuator><motor joint="left"/><motor joint="right"/><motor tendon="hip"/><motor joint="roll"/></actuator></mujoco>'''
def pgeoms(s):
    n=s.normal(0,0); return f'<geom type="plane" size="100 100 1" zaxis="{n[0]} {n[1]} {n[2]}" contype="0" conaffinity="3"/>'
Plane.geoms=pgeoms
def sgeoms(s):
    xs=[-5]+[s.f+s.t*k for k in range(40)]; return ''.join(f'<geom type="box" pos="{(a+b)/2} 0 {s.r*k-1}" size="{(b-a)/2} 20 1" contype="0" conaffinity="3"/>' for k,(a,b) in enumerate(zip(xs,xs[1:])))
Steps.geoms=sgeoms
def mjwalk(c,ground,steps=30,h=2e-4,period=1e-3,torsion=.05,start=None):
    robot=c.robot; l=robot.leg_length; model=mujoco.MjModel.from_xml_string(mjcf(robot,h,ground,torsion)); d=mujoco.MjData(model)
    feet=[model.geom('left_foot').id,model.geom('right_foot').id]
    X,Y,Z,YAW,ROLL,L,R=range(7); LEG=[L,R]
    st=c.gait.start if start is None else start; q,dq=st[:3],st[3:]
    f=first_footing(np.array([0,.05,ground.height(0,.05)]),ground.normal(0,.05))
    # place: yaw, roll from axle
    e,up=f.axes(q[2]); left=-e # e towards swing side (right): left = -e
    roll=math.asin(left[2]); yaw=math.atan2(-left[0],left[1]); 
    def axes(yaw,roll):
        cy,sy,cr,sr=math.cos(yaw),math.sin(yaw),math.cos(roll),math.sin(roll)
        return np.array([cy,sy,0]),np.array([-sy*cr,cy*cr,sr]),np.array([sy*sr,-cy*sr,cr])
    x_,y_,z_=axes(yaw,roll)
    th=[]
    for a in q[:2]:
        u=f.forward*math.sin(a)+up*math.cos(a); th.append(math.atan2(u@x_,u@z_))
    d.qpos[[YAW,ROLL,L,R]]=[yaw,roll,th[0],th[1]]
    mujoco.mj_kinematics(model,d); d.qpos[:3]=f.place-d.geom_xpos[feet[0]]+f.normal*4e-5
    # rates: angular velocity of pelvis = -dq_roll about forward for left stance (roll positive leans towards stance side=left)
    om=-f.forward*dq[2]*1.0
    d.qvel[ROLL]=om@x_; d.qvel[YAW]=om[2]-0*d.qvel[ROLL]; 
    phidot=0
    d.qvel[[L,R]]=dq[:2]
    mujoco.mj_forward(model,d); jac=np.zeros((3,7)); mujoco.mj_jacGeom(model,d,jac,None,feet[0]); d.qvel[:3]-=jac@d.qvel
    stance=0; sigma=-1.0; n=f.normal; fwd=f.forward
    def see():
        x_,y_,z_=axes(d.qpos[YAW],d.qpos[ROLL]); w=np.array([0,0,d.qvel[YAW]])+d.qvel[ROLL]*x_
        e=y_ if sigma>0 else -y_
        s=math.asin(max(-1,min(1,e@n))); ds=np.cross(w,e)@n/math.cos(s)
        a,b=n@x_,n@z_; phi=math.atan2(a,b); dphi=(b*(n@np.cross(w,x_))-a*(n@np.cross(w,z_)))/(a*a+b*b)
        i,j=LEG[stance],LEG[1-stance]
        return np.array([d.qpos[i]-phi,d.qpos[j]-phi,s]),np.array([d.qvel[i]-dphi,d.qvel[j]-dphi,ds])
    q,dq=see(); mem=[0.0]*c.memory_size; c.start(mem,q,dq)
    model.geom_contype[feet[1]]=0
    t0=0;nxt=0;k=0;on=False;out=None;work=wr=0;pk=np.zeros(3);rows=[];yawmax=0;slip=0;p0=d.geom_xpos[feet[0]].copy()
    while k<steps:
        mujoco.mj_step1(model,d); t=d.time-t0; sp,tp=d.geom_xpos[feet[1-stance]],d.geom_xpos[feet[stance]]
        x_=np.array([math.cos(d.qpos[YAW]),math.sin(d.qpos[YAW]),0]); ahead=(sp-tp)@x_; gap=sp[2]-ground.height(sp[0],sp[1])
        if not on and t>.1 and ahead>.2*l and gap>0: on=True; model.geom_contype[feet[1-stance]]=2-stance; mujoco.mj_step1(model,d)
        landed=False
        if on and gap<5e-3 and d.ncon:
            g=d.contact.geom
            landed=any(feet[1-stance] in g[i] for i in range(d.ncon))
        if landed: model.geom_contype[feet[stance]]=0; mujoco.mj_step1(model,d)
        if d.time>=nxt-1e-9:
            q,dq=see(); out=np.array(c.torque(mem,t,q,dq)); nxt+=period
            for i in range(3): mem[i]+=period*out[3+i]
        d.ctrl[:]=0; d.ctrl[stance]=out[0]; d.ctrl[2]=out[1] if stance==0 else -out[1]; d.ctrl[3]=sigma*out[2]
        mujoco.mj_step2(model,d)
        qq,dd=see(); pw=abs(out[:3]*robot.joint_rates(dd)); work+=h*pw[:2].sum(); wr+=h*pw[2]; pk=np.maximum(pk,abs(out[:3]))
        if landed:
            mujoco.mj_kinematics(model,d); qb=see()[0]; stance,sigma=1-stance,-sigma
            p=d.geom_xpos[feet[stance]].copy(); slip=max(slip,0); n=ground.normal(p[0],p[1]); on=False; t0=d.time; k+=1
            q,dq=see(); c.on_touchdown(mem,qb,q,dq); nxt=d.time; rows.append((d.time,*q,*dq,*p,math.degrees(d.qpos[YAW]),c.slope_estimate(mem),c.lateral_estimate(mem)))
        if d.qpos[Z]-ground.height(d.qpos[0],d.qpos[1])<.5*l or abs(d.qpos[ROLL])>.7: return 'fell',k,rows,0,0,pk
        if d.time-t0>3.2: return 'stalled',k,rows,0,0,pk
    Wt=(2*robot.leg_mass+robot.hip_mass)*robot.gravity; x=rows[-1][7]
    return 'finished',k,rows,work/(Wt*x),wr/(Wt*x),pk
if __name__=='__main__':
    g=make(); c=SpatialController(g.robot,g)
    for name,gr in dict(level=Plane(),down3=Plane(3),lat3=Plane(0,3),stepsup=Steps(.02)).items():
        t=time.time(); o=mjwalk(c,gr,20); r=np.array(o[2]); print(name,o[0],o[1],'c_mt %.4f + %.4f'%(o[3],o[4]),o[5],'roll',np.degrees(r[:,3].min()),np.degrees(r[:,3].max()),'y',r[-1,8],'yaw',abs(r[:,10]).max(),'est',np.degrees(r[-1,11:]),round(time.time()-t,1),flush=True)
