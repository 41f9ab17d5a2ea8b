"""A pivoting grasp in MuJoCo: an object on a free hinge, which an arm presses on a pad and drags along it.

Started by ``cargo xtask monte-carlo-pivot --mujoco``; each line that comes in is a scene,

    {"harmonics_m": [[a, b], ...], "mean_radius_m": r, "center_of_mass_m": [x, y], "tilt_rad": t, "friction": mu,
     "strokes": [{"along_m": [...], "press": n}, ...], "drag_m_per_s": v, "lift_m_per_s": w, "rate_hz": f}

and is answered by five numbers per sample: time, way of the pivot along the pad and its height over it, the contact
along the pad (nan without one), and ψ less the tilt of the pad. Everything is in the frame of the pad, in which
gravity is tilted. The hinge and the arm are MuJoCo's own joints and actuators; contact is found by its collision
detection and read off its contact forces, as a pad would feel it.
"""

import json
import sys

import mujoco
import numpy as np
from support_function import outline

MASS_KG = 0.05
GRAVITY_M_PER_S2 = 9.80665
STEP_S = 1e-4
CONTACT_STEPS = 2.0  # time constant of a contact in steps: the stiffest that MuJoCo allows
VERTICES = 6000  # of the rim: a facet of 0.03 mm on an object of 30 mm
CONTROL_S = 1e-3  # the arm is told where to go so often
DAMPING = 0.5  # of the hinge, as a share of what is critical for the object hanging from it
LEAST_FORCE = 0.02  # of the weight: a lighter touch is not felt

MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="{gravity_x} {gravity_y} 0" integrator="implicitfast" cone="elliptic" impratio="10" timestep="{step}"/>
  <default>
    <geom condim="3" friction="{friction} 0 0" solimp="0.9999 0.9999 0.001" solref="{contact} 1"/>
  </default>
  <asset><mesh name="rim" vertex="{vertices}" inertia="shell"/></asset>
  <worldbody>
    <geom type="plane" size="5 5 1" quat="{half} -{half} 0 0" contype="1" conaffinity="0"/>
    <body name="arm" gravcomp="1">
      <joint name="along" type="slide" axis="1 0 0"/><joint name="above" type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>
      <body name="object">
        <joint name="hinge" type="hinge" axis="0 0 1" damping="{damping}"/>
        <inertial pos="{x} {y} 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
        <geom type="mesh" mesh="rim" contype="0" conaffinity="1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="along" kp="1e5" kv="400"/>
    <position joint="above" kp="5e3" kv="60" forcelimited="true" forcerange="-1 100"/>
  </actuator>
</mujoco>
"""


def compiled(scene):
    """The model of a scene."""
    # A lens: the rim, and one vertex before and behind it.
    points = np.zeros((VERTICES + 2, 3))
    points[:-2, :2] = outline(scene, VERTICES)
    points[-2:, 2] = [0.01, -0.01]
    radius_m = scene["mean_radius_m"]
    inertia = 0.5 * MASS_KG * radius_m**2
    x, y = scene["center_of_mass_m"]
    swinging = inertia + MASS_KG * (x * x + y * y)
    critical = 2 * np.sqrt(swinging * MASS_KG * GRAVITY_M_PER_S2 * np.hypot(x, y))
    text = MODEL.format(
        gravity_x=-GRAVITY_M_PER_S2 * np.sin(scene["tilt_rad"]),
        gravity_y=-GRAVITY_M_PER_S2 * np.cos(scene["tilt_rad"]),
        step=STEP_S,
        friction=scene["friction"],
        contact=CONTACT_STEPS * STEP_S,
        vertices=" ".join(map(repr, points.ravel().tolist())),
        half=np.sqrt(0.5),
        damping=DAMPING * critical,
        x=x,
        y=y,
        mass=MASS_KG,
        inertia=inertia,
    )
    return mujoco.MjModel.from_xml_string(text)


def normal_force(model, data):
    """The force on the pad, and its moment about the foot of the pivot."""
    force, sum_n, sum_nm = np.zeros(6), 0.0, 0.0
    for index in range(data.ncon):
        mujoco.mj_contactForce(model, data, index, force)
        sum_n += force[0]
        sum_nm += force[0] * (data.contact[index].pos[0] - data.qpos[0])
    return np.array([sum_n, sum_nm])


class Run:
    """A scene as it goes."""

    def __init__(self, scene):
        self.scene = scene
        self.model = compiled(scene)
        self.data = mujoco.MjData(self.model)
        points = outline(scene, VERTICES)
        self.clear_m = 1.1 * np.hypot(*points.T).max()
        # It hangs free.
        x, y = scene["center_of_mass_m"]
        self.data.qpos[:] = [0.0, self.clear_m, -np.pi / 2 - scene["tilt_rad"] - np.arctan2(y, x)]
        self.target = np.array([0.0, self.clear_m])
        self.next_sample_s = 0.0
        self.rows = []

    def step(self, to, speed_m_per_s):
        """The target goes there at a speed, and the object with it."""
        to = np.asarray(to, dtype=float)
        way_m = np.abs(to - self.target).max()
        for part in np.linspace(0, 1, max(1, round(way_m / speed_m_per_s / CONTROL_S)) + 1)[1:]:
            self.data.ctrl[:] = self.target + part * (to - self.target)
            self.pass_time()
        self.target = to

    def pass_time(self):
        """Until the arm is told where to go again; writes down a sample when its time has come."""
        steps = round(CONTROL_S / STEP_S)
        if self.data.time < self.next_sample_s:
            mujoco.mj_step(self.model, self.data, steps)
            return
        self.next_sample_s += 1 / self.scene["rate_hz"]
        # A rim of facets goes from one to the next in leaps that no pad resolves: it feels the mean of a while.
        states, forces = [], np.zeros(2)
        for _ in range(steps):
            mujoco.mj_step1(self.model, self.data)
            states.append([self.data.time, *self.data.qpos])
            mujoco.mj_step2(self.model, self.data)
            forces += normal_force(self.model, self.data)
        time_s, along_m, above_m, psi_rad = np.mean(states, axis=0)
        is_felt = forces[0] > LEAST_FORCE * MASS_KG * GRAVITY_M_PER_S2 * steps
        self.rows += [time_s, along_m, above_m, along_m + forces[1] / forces[0] if is_felt else np.nan, psi_rad]

    def stroke(self, along_m, press):
        """Over the first place, down, along, and up."""
        lift, drag = self.scene["lift_m_per_s"], self.scene["drag_m_per_s"]
        self.data.qpos[0] = self.target[0] = along_m[0]
        self.data.qvel[0] = 0
        self.model.actuator_forcerange[1] = [-press * MASS_KG * GRAVITY_M_PER_S2, 100]
        # Below the pad: the arm presses with all that it may.
        self.step([along_m[0], -0.01], lift)
        for place_m in along_m[1:]:
            self.step([place_m, -0.01], drag)
        self.target[1] = self.data.qpos[1]
        self.step([along_m[-1], self.clear_m], lift)
        # It swings to rest.
        for _ in range(round(1 / CONTROL_S)):
            self.pass_time()


def main():
    """Answers until nothing more is asked."""
    for line in sys.stdin:
        scene = json.loads(line)
        run = Run(scene)
        for stroke in scene["strokes"]:
            run.stroke(stroke["along_m"], stroke["press"])
        print(*run.rows, flush=True)


if __name__ == "__main__":
    main()
