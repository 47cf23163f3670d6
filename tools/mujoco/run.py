"""Runs MuJoCo along recorded trials: jobs in, what its sensors would show out.

Started by `stickslip mujoco`. One job a line on stdin (JSON: xml, t_s, gripper poses,
grip_n, pusher reference), one answer a line on stdout. Gripper and grip follow the
recording; object and forces are the engine's. Time is that of mj_step alone.
"""

import json
import sys
import time

try:
    import mujoco
    import numpy as np
except ImportError as error:
    print(f"{sys.executable}: {error}", file=sys.stderr)
    sys.exit(3)

# Grip builds up for this long before the trial begins: without gravity, as the object
# shall not fall while nothing holds it yet; what lies on a table or platform rests there
# with its weight first, and is gripped then.
SETTLE_S = 0.1


def slerp(a, b, share):
    b = b if np.dot(a, b) >= 0 else -b
    q = a + share * (b - a)
    return q / np.linalg.norm(q)


def local_velocity(a, b, dt):
    """Angular velocity in the axes of `a` that leads from `a` to `b`."""
    w = np.zeros(3)
    mujoco.mju_subQuat(w, b, a)
    return w / dt


class Trial:
    def __init__(self, job):
        self.model = mujoco.MjModel.from_xml_string(job["xml"])
        self.data = mujoco.MjData(self.model)
        self.t = np.array(job["t_s"])
        self.gripper = np.array(job["gripper"]) if job["gripper"] else None
        self.grip = np.array(job["grip_n"])
        self.rests = job["rests"]
        self.reference = np.array(job["reference_m"])
        m = self.model
        name = lambda kind, n: mujoco.mj_name2id(m, kind, n)
        body, joint = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_JOINT
        self.object = name(body, "object")
        self.fingers = [name(body, "finger1"), name(body, "finger2")]
        at = name(joint, "gripper")
        self.g_q = m.jnt_qposadr[at] if at >= 0 else None
        self.g_v = m.jnt_dofadr[at] if at >= 0 else None
        self.geom = {}
        for g in range(m.ngeom):
            b = m.geom_bodyid[g]
            label = mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_GEOM, g)
            if b in self.fingers:
                self.geom[g] = self.fingers.index(b)
            elif label == "pusher":
                self.geom[g] = 2
            elif label == "support":
                self.geom[g] = 3
        self.steps, self.time = 0, 0.0

    def drive(self, a, b, share, dt):
        """Gripper at `share` of the way between two poses, with its velocity."""
        if self.g_q is None or self.gripper is None:
            return
        p, q = a[:3] + share * (b[:3] - a[:3]), slerp(a[3:], b[3:], share)
        d = self.data
        d.qpos[self.g_q : self.g_q + 3] = p
        d.qpos[self.g_q + 3 : self.g_q + 7] = q
        d.qvel[self.g_v : self.g_v + 3] = (b[:3] - a[:3]) / dt if dt > 0 else 0.0
        d.qvel[self.g_v + 3 : self.g_v + 6] = local_velocity(a[3:], b[3:], dt) if dt > 0 else 0.0

    def step(self):
        start = time.perf_counter()
        mujoco.mj_step(self.model, self.data)
        self.time += time.perf_counter() - start
        self.steps += 1

    def read(self, out):
        """Sums contact forces on the object by body."""
        m, d = self.model, self.data
        force, torque, normal = np.zeros((4, 3)), np.zeros((4, 3)), np.zeros(4)
        points = np.zeros(4, dtype=int)
        f = np.zeros(6)
        turn = np.eye(3)
        if self.g_q is not None:
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, d.qpos[self.g_q + 3 : self.g_q + 7])
            turn = turn.reshape(3, 3)
        for i in range(d.ncon):
            c = d.contact[i]
            g1, g2 = c.geom[0], c.geom[1]
            other, sign = (g1, 1.0) if m.geom_bodyid[g2] == self.object else (g2, -1.0)
            k = self.geom.get(other)
            if k is None:
                continue
            mujoco.mj_contactForce(m, d, i, f)
            world = sign * (c.frame.reshape(3, 3).T @ f[:3])
            about = d.xpos[self.fingers[k]] if k < 2 else self.reference
            force[k] += world
            torque[k] += np.cross(c.pos - about, world)
            normal[k] += f[0]
            points[k] += f[0] > 1e-6
        rows = [np.concatenate([turn.T @ force[k], turn.T @ torque[k]]).tolist() for k in range(2)]
        out["finger1"].append(rows[0])
        out["finger2"].append(rows[1])
        out["pusher"].append(np.concatenate([force[2], torque[2]]).tolist())
        out["normal"].append(normal.tolist())
        out["points"].append(points.tolist())
        out["object"].append(np.concatenate([d.xpos[self.object], d.xquat[self.object]]).tolist())

    def run(self):
        m, d = self.model, self.data
        keys = ["object", "finger1", "finger2", "pusher", "normal", "points"]
        out = {k: [] for k in keys}
        step = m.opt.timestep
        gravity = m.opt.gravity.copy()
        pose = lambda i: self.gripper[i] if self.gripper is not None else None
        phases = [(gravity, 0.0), (gravity, self.grip[0])] if self.rests else [(0 * gravity, self.grip[0])]
        for g, grip in phases:
            m.opt.gravity[:] = g
            if m.nu:
                d.ctrl[:] = grip
            for _ in range(int(SETTLE_S / step)):
                self.drive(pose(0), pose(0), 0.0, 0.0)
                mujoco.mj_step(m, d)
        m.opt.gravity[:] = gravity
        self.drive(pose(0), pose(0), 0.0, 0.0)
        self.step()
        self.read(out)
        for i in range(1, len(self.t)):
            dt = self.t[i] - self.t[i - 1]
            parts = max(1, int(np.ceil(dt / step - 1e-6)))
            m.opt.timestep = dt / parts
            if m.nu:
                d.ctrl[:] = self.grip[i]
            for k in range(parts):
                self.drive(pose(i - 1), pose(i), k / parts, dt)
                self.step()
            self.read(out)
        out["steps"], out["step_s"] = self.steps, self.time
        out["warnings"] = int(sum(w.number for w in d.warning))
        out["version"] = mujoco.__version__
        return out


for line in sys.stdin:
    try:
        answer = Trial(json.loads(line)).run()
    except Exception as error:  # reported with the trial, the others go on
        answer = {"error": f"{type(error).__name__}: {error}"}
    print(json.dumps(answer), flush=True)
