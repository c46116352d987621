"""What does not change in a walk in MuJoCo; `setup` fills it in."""

from __future__ import annotations

from mjbiped.disturbances.chance import Pushes
from mjbiped.numerics.blocks import Block, reader


class Constants(Block):
    """What does not change in a walk while its scene is the same, and where things are.

    Attributes:
        state: The walk's `State`, alone in a list.
        whole: The state and the row in one.
        row: Of the last touchdown, in the order of the record's columns; behind the state in userdata.
        memory: The controller's memory, behind that.
        rates: Of its integrated states, held between ticks, behind that.
        time: `mjData.time`.
        timestep: `mjModel.opt.timestep`.
        warnings: Kind and number of each of MuJoCo's warnings in turn.
        qpos: See MuJoCo for this and all that follow.
        qvel: See there.
        qacc: See there.
        qacc_warmstart: See there.
        ctrl: See there.
        qfrc_applied: Forces at the degrees of freedom; that at hip x is a push's, N.
        sensordata: Data of all sensors.
        geom_contype: Contact bits of geoms.
        geom_conaffinity: The same.
        geom_solref: Softness of contacts, two numbers a geom.
        jnt_solref: Softness of the joints' limits, two numbers a joint.
        eq_solref: Softness of equality constraints, two numbers each.
        eq_data: `EQ_DATA` numbers of each, the flexion first at which a lock holds.
        eq_active: Whether each is switched on.

        legs: The robot's legs, in the order in which they stand.
        leg_count: Their number.
        order: For each of the robot's `places` its index in qpos.
        nq: Number of these.
        angles: Number of the robot's angles, and of its joints with motors.
        hip: Actuator between the legs; -1: there is none.
        slots: Floats of one foot's contacts in the sensor data.
        nsensordata: Floats of all sensor data.
        nu: Number of actuators.
        ngeom: Number of geoms.
        njnt: Number of joints.
        neq: Number of equality constraints.
        x: Starts of the ground's segments, m; with the three that follow it is a `terrain.profile.Profile`.
        z: Heights there, m.
        gradient: dz/dx.
        segments: Number of segments, as far as the ground was built.
        rises: Steps up at the starts of segments, m.
        pieces: For each segment the geom that is its ground.
        firsts: For each segment the first one that shares its geom.
        lasts: The last one.
        risers: For each segment the geom that is the riser at its start; -1: there is none.
        sills: For each segment the geom of the lower ground behind that riser; -1: there is none.

        leg_length: Of a leg, m.
        lowest_hip: Height of the hip over the ground below which the robot has fallen, m.
        foot_radius: Of the sphere that stands on the ground, m.
        rolling_radius: On which a standing foot rolls, m: 0 where the sphere's centre is held.
        weight: Of the robot, N.
        reach: Distance of the scuffing rule, m.
        delay: Time of the scuffing rule, s.
        stall_time: Longest time without touchdown, s.
        averaged: Least time over which the stance foot's normal force is averaged, s.
        airborne: Time without contact after which a stance foot is off the ground, s.
        sustained: Time for which friction must be asked for to count, s.
        start: Where the ground begins, x in m.
        end: Where it ends, x in m.
        steps: Touchdowns after which the walk is finished.
        distance: Position of the stance foot at which it is finished, x in m.
        scuffs: Whether the scuffing rule says when the swing foot collides; else it always does.
        stepped: Whether there are steps in the ground.
        deepest: No foot is deeper in the ground than this in the first step of a contact, m.
        longest: Longest physics step, s.
        shortest: Length of the step that makes an impact, s.
        sliding: Length of the steps in which the swing foot slides on a riser's face, s: no longer step is made there.
        lands: Whether steps end at impacts; else they all are of one length, and MuJoCo's own.
        radius: Of round feet, m; 0: point feet.
        feet: Whether feet turn about ankles.
        box: Whether these stand on all of their soles.
        behind: Distance from the ankle to the heel of a massless sole, m; infinity without one.
        ahead: Distance from the ankle to its toe, m.
        knee_opens: Whether the stop alone holds the knee of the leg that leaves the ground; see `Robot.knee_opens`.
        knee_stiffness: Of the servo at the stance knee, N m/rad; 0: there is none, and the stance knee is locked.
        knee_damping: N m s/rad.
        foot_stiffness: Of the servo of the swing foot, N m/rad.
        foot_damping: N m s/rad.

        parameters: Of the controller's law; see `mjbiped.control.controller.Law` for this and all that follow.
        torque: See there.
        touchdown: See there.
        slope_estimate: See there.
        next_discontinuity: See there; not called here.
        tick: See there.
        knee_strike: See there.
        failed: A float that is not zero once a law has raised an exception.
        room: `motors.SPARE` floats and more, into which `torque` writes.
        control_period: Time between two ticks of the controller, s; 0: it ticks at every physics step.
        memory_size: Floats of the controller's memory.
        states: Number of its integrated states.
        sampled: Whether it is in a loop with disturbances, which holds its torques.
        ticks: Whether its law has a tick.
        support: See `Controller.support`.
        pushes: Pushes at the hip, alone in a list; see `disturbances.chance.Pushes`.

        sample_period: Time between two samples, s; each is taken at the first physics step from then on.
        samples: Rows of samples, one behind the other, which whoever takes them counts in `State.samples`.
        rows: Rows of touchdowns, the same.
        sample_room: Number of rows of samples that there is room for; more are not written.
        row_room: Number of rows of touchdowns.
        sample_width: Floats of a sample; the controller's integrated states stand at its end.
        row_width: Floats of a touchdown.
        estimate_at: Index in a touchdown of the slope estimate before its update; that after it follows.
    """


constants_at = reader(Constants)
pushes_at = reader(Pushes)
