"""An object between two palms in MuJoCo, without friction, driven so slowly that it is as good as at rest.

Started with the scene that ``cargo xtask bench-peers`` writes; each line that comes in asks for one run,

    VERTICES DURATION_S STEP_S DAMPING

and is answered by the seconds that the steps took, without the compilation of the model, and ψ at each sample of the
scene. The object is a mesh whose rim has so many vertices, or the ellipsoid of the scene when they are 0. The steps run
in MuJoCo's own loop (``mujoco.rollout``) on one thread; no Python is called between them.
"""

import functools
import json
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout
from scipy.interpolate import CubicHermiteSpline
from support_function import outline

MASS_KG = 0.1  # of no consequence
GRAVITY_M_PER_S2 = 9.80665
CONTACT_STEPS = 2.0  # time constant of a contact in steps: the stiffest that MuJoCo allows

PALMS = mujoco.mjtState.mjSTATE_MOCAP_POS.value | mujoco.mjtState.mjSTATE_MOCAP_QUAT.value
STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS.value

# Three degrees of freedom and one contact force per palm: the plane is all that MuJoCo has to compute.
MODEL = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 {gravity} 0" integrator="implicitfast"/>
  <default><geom condim="1" contype="0" conaffinity="1" solimp="0.9999 0.9999 0.001"/></default>
  <asset>{asset}</asset>
  <worldbody>
    <body mocap="true"><geom type="plane" size="1 1 1" contype="1" conaffinity="0"/></body>
    <body mocap="true"><geom type="plane" size="1 1 1" contype="1" conaffinity="0"/></body>
    <body>
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
      {geom}
    </body>
  </worldbody>
</mujoco>
"""


def model(scene, vertices):
    """The compiled model."""
    if vertices:
        # A lens: the rim, and one vertex before and behind it. Half the vertices of a prism.
        points = np.zeros((vertices + 2, 3))
        points[:-2, :2] = outline(scene, vertices)
        points[-2:, 2] = [0.01, -0.01]
        text = " ".join(map(repr, points.ravel().tolist()))
        asset, geom = f'<mesh name="rim" vertex="{text}" inertia="shell"/>', '<geom type="mesh" mesh="rim"/>'
    else:
        (a, b), (x, y) = scene["ellipsoid"]["half_axes_m"], scene["ellipsoid"]["center_m"]
        asset, geom = "", f'<geom type="ellipsoid" size="{a} {b} {b}" pos="{x} {y} 0"/>'
    inertia = 0.5 * MASS_KG * scene["mean_radius_m"] ** 2
    text = MODEL.format(asset=asset, geom=geom, gravity=-GRAVITY_M_PER_S2, mass=MASS_KG, inertia=inertia)
    return mujoco.MjModel.from_xml_string(text)


def facing(x, y):
    """Quaternions that turn the z axis, the normal of a plane, to (x, y, 0)."""
    half = np.full_like(x, np.sqrt(0.5))
    return np.stack([half, -half * y, half * x, 0 * x], axis=1)


def run(scene, model, duration_s, step_s, damping):
    """Seconds, and ψ at each sample."""
    model.opt.timestep = step_s
    model.geom_solref[:] = [CONTACT_STEPS * step_s, 1]
    rate = np.sqrt(GRAVITY_M_PER_S2 / scene["mean_radius_m"])
    model.dof_damping[2] = damping * rate * 0.5 * MASS_KG * scene["mean_radius_m"] ** 2
    samples_s = np.array(scene["time_s"]) * duration_s / scene["time_s"][-1]
    steps = round(duration_s / step_s)
    # A contact follows a palm with a delay of twice its time constant: the palms are led by as much.
    times_s = np.clip(step_s * (np.arange(steps) + 2 * CONTACT_STEPS), 0, duration_s)
    angles = np.array([scene["phi1_rad"], scene["phi12_rad"]]).T
    phi1, phi12 = CubicHermiteSpline(samples_s, angles, np.gradient(angles, samples_s, axis=0))(times_s).T
    palms = np.zeros((steps, 14))
    palms[:, 6:10], palms[:, 10:14] = facing(-np.sin(phi1), np.cos(phi1)), facing(np.sin(phi12), -np.cos(phi12))
    data = mujoco.MjData(model)
    data.qpos[:] = [*scene["start_center_m"], scene["start_psi_rad"]]
    start = np.zeros(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, start, STATE)
    began = time.perf_counter()
    states, _ = rollout.rollout(model, data, start[None], palms[None], control_spec=PALMS)
    seconds = time.perf_counter() - began
    # State: time, then position and orientation.
    psi = np.concatenate([[scene["start_psi_rad"]], states[0, :, 3]])
    return seconds, psi[np.clip(np.round(samples_s / step_s).astype(int), 0, steps)]


def main():
    """Answers until nothing more is asked."""
    scene = json.loads(Path(sys.argv[1]).read_text())
    compiled = functools.cache(lambda vertices: model(scene, vertices))
    for line in sys.stdin:
        vertices, *settings = line.split()
        seconds, psi = run(scene, compiled(int(vertices)), *map(float, settings))
        print(seconds, *psi.tolist(), flush=True)


if __name__ == "__main__":
    main()
