#!/usr/bin/env python3
"""A ROS 2 node that predicts slip and drop: wrenches, poses and grip command in, flags out.

    python3 ros2_slip_node.py --ros-args --params-file slip.yaml

Needs rclpy, geometry_msgs, std_msgs and the package stickslip in one Python. Tested against a stub of rclpy, never in
a real ROS graph. docs/python.md has the parameters, and what frames and signs are expected.

Two parts: :class:`Assembler` makes one sample of messages that come when they like, and knows nothing of ROS;
:class:`SlipNode` converts messages, steps the predictor at each sample and publishes what it says.
"""

from __future__ import annotations

import json
import math
from collections import deque
from dataclasses import dataclass, field

import rclpy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Bool, Float64, String

import stickslip

# The predictor's tick, s.
PERIOD_S = 0.004
WAITING = "doubt: waiting for the object's pose"


# --- Frames: poses are x, y, z (m), qw, qx, qy, qz; wrenches fx, fy, fz (N), tx, ty, tz (N m) ---


def turned(q, v):
    """The vector ``v`` turned by the unit quaternion ``q`` (w, x, y, z)."""
    w, x, y, z = q
    # v + 2 q x (q x v + w v)
    cx, cy, cz = y * v[2] - z * v[1] + w * v[0], z * v[0] - x * v[2] + w * v[1], x * v[1] - y * v[0] + w * v[2]
    return [v[0] + 2 * (y * cz - z * cy), v[1] + 2 * (z * cx - x * cz), v[2] + 2 * (x * cy - y * cx)]


def composed(outer, inner):
    """The pose ``inner``, given in the frame of the pose ``outer``, in the frame of that."""
    (aw, ax, ay, az), (bw, bx, by, bz) = outer[3:], inner[3:]
    moved = turned(outer[3:], inner[:3])
    return [
        *(o + m for o, m in zip(outer[:3], moved)),
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]


@dataclass(frozen=True)
class Sensor:
    """How a force/torque sensor sits in its finger."""

    # Turns the sensor's axes into the gripper's: w, x, y, z.
    quaternion_wxyz: tuple = (1.0, 0.0, 0.0, 0.0)
    # From the pad's centre to the sensor's origin, gripper axes.
    lever_m: tuple = (0.0, 0.0, 0.0)
    # "object": the sensor gives the force on the object; "finger": the reaction, and all signs are turned.
    acts_on: str = "finger"

    def on_object(self, wrench):
        """What the predictor takes: on the object, in gripper axes, about the pad's centre."""
        force, torque = list(wrench[:3]), list(wrench[3:])
        # What changes nothing is left out: numbers stay as they were, to the last bit.
        if self.quaternion_wxyz != (1.0, 0.0, 0.0, 0.0):
            force, torque = turned(self.quaternion_wxyz, force), turned(self.quaternion_wxyz, torque)
        if any(self.lever_m):
            (x, y, z), (fx, fy, fz) = self.lever_m, force
            torque = [a + b for a, b in zip(torque, (y * fz - z * fy, z * fx - x * fz, x * fy - y * fx))]
        sign = -1.0 if self.acts_on == "finger" else 1.0
        return [sign * number for number in (*force, *torque)]


# --- From messages to samples ---


@dataclass
class Sample:
    """What is known at one tick; ``None``: not measured."""

    t_s: float
    fingers: list
    gripper: list | None
    object: list | None


@dataclass
class Settings:
    """Times that say which messages belong together, s."""

    # Wrenches of both fingers nearer than this are one sample.
    pair_s: float = 0.5 * PERIOD_S
    # So long, by the stamps of the wrenches, a sample waits for what is missing in it.
    late_s: float = 2.0 * PERIOD_S
    # A pose of the gripper stands for so long, as on a board.
    gripper_age_s: float = 0.02
    # A pose of the object that is older when it comes is none.
    object_age_s: float = 0.03
    # Stamps that go back by more are another clock.
    jump_s: float = 1.0
    # One wrench in so many is used: 4 for sensors of 1 kHz.
    every: int = 1
    # Which fingers have a sensor.
    sensors: tuple = (True, True)


class Poses:
    """The newest poses of one body, in any order."""

    def __init__(self):
        self.clear()

    def clear(self):
        self.known = deque(maxlen=64)
        self.used_s = -math.inf

    def add(self, t_s, pose):
        self.known.append((t_s, pose))

    def at(self, t_s, age_s):
        """The pose nearest to ``t_s`` that is not older than ``age_s``: stamp and pose."""
        fits = [one for one in self.known if -age_s <= one[0] - t_s <= 0.5 * PERIOD_S]
        return min(fits, key=lambda one: abs(one[0] - t_s), default=None)

    def once(self, t_s, age_s):
        """The same, each measurement once: a pose that is repeated looks as if the object stood still."""
        found = self.at(t_s, age_s)
        if found is None or found[0] <= self.used_s:
            return None
        self.used_s = found[0]
        return found[1]

    def due(self, t_s):
        """Whether a pose of this time is about to come: they come about every tick, and the newest is older."""
        if len(self.known) < 2:
            return False
        (before_s, _), (last_s, _) = self.known[-2], self.known[-1]
        return 0.0 < last_s - before_s < 1.5 * PERIOD_S and -4.0 * PERIOD_S < last_s - t_s < -0.5 * PERIOD_S


@dataclass
class Assembler:
    """Makes samples in order of time from messages that come late, out of order or not at all."""

    settings: Settings = field(default_factory=Settings)

    def __post_init__(self):
        self.gripper, self.object = Poses(), Poses()
        # Messages that came too late for their sample, and clocks that jumped.
        self.late = self.jumps = 0
        self.clear()

    def clear(self):
        """Forgets all that waits."""
        self.waiting = ([], [])
        self.newest_s = self.done_s = -math.inf
        self.ticks = 0
        self.gripper.clear()
        self.object.clear()

    def wrench(self, finger, t_s, wrench):
        """Takes a wrench (``None``: unusable) of finger 0 or 1; the samples that are complete now."""
        if t_s < self.newest_s - self.settings.jump_s:
            self.clear()
            self.jumps += 1
        if t_s <= self.done_s:
            self.late += 1
            return []
        self.newest_s = max(self.newest_s, t_s)
        self.waiting[finger].append((t_s, wrench))
        self.waiting[finger].sort(key=lambda one: one[0])
        return self.complete()

    def pose(self, poses, t_s, pose):
        """Takes a pose of ``self.gripper`` or ``self.object``; the samples that are complete now."""
        poses.add(t_s, pose)
        return self.complete()

    def complete(self):
        samples = []
        while any(self.waiting):
            first = min((f for f in (0, 1) if self.waiting[f]), key=lambda f: self.waiting[f][0][0])
            other = self.waiting[1 - first]
            t_s = self.waiting[first][0][0]
            paired = bool(other) and other[0][0] - t_s <= self.settings.pair_s
            missing = not paired and self.settings.sensors[1 - first]
            missing = missing or self.gripper.due(t_s) or self.object.due(t_s)
            if missing and self.newest_s - t_s < self.settings.late_s:
                break
            fingers = [None, None]
            fingers[first] = self.waiting[first].pop(0)[1]
            self.done_s = t_s
            if paired:
                self.done_s, fingers[1 - first] = other.pop(0)
            self.ticks += 1
            if (self.ticks - 1) % self.settings.every == 0:
                gripper = self.gripper.at(t_s, self.settings.gripper_age_s)
                seen = self.object.once(t_s, self.settings.object_age_s)
                samples.append(Sample(t_s, fingers, None if gripper is None else gripper[1], seen))
        return samples


# --- The node ---


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


def finite(numbers):
    return all(map(math.isfinite, numbers))


class SlipNode(Node):
    """Subscribes, steps the predictor by the wrenches' stamps, publishes."""

    def __init__(self):
        super().__init__("stickslip")

        def parameter(name, value):
            return self.declare_parameter(name, value).value

        rig, model = parameter("rig", ""), parameter("model", "")
        self.predictor = stickslip.Predictor(
            rig,
            parameter("object", ""),
            model or None,
            primitive=parameter("primitive", "lift"),
            grip_n=parameter("grip_n", 0.0),
        )
        topics = {
            name: parameter(f"topics.{name}", topic)
            for name, topic in [
                ("finger1", "/finger1/wrench"),
                ("finger2", "/finger2/wrench"),
                ("gripper", "/gripper/pose"),
                ("object", ""),
                ("grip", "/gripper/grip_command"),
            ]
        }
        times = Settings()
        for name in ("pair_s", "late_s", "gripper_age_s", "object_age_s", "jump_s", "every"):
            setattr(times, name, parameter(name, getattr(times, name)))
        times.sensors = (bool(topics["finger1"]), bool(topics["finger2"]))
        self.assembler = Assembler(times)
        self.sensors = [
            Sensor(
                tuple(parameter(f"{name}.quaternion_wxyz", [1.0, 0.0, 0.0, 0.0])),
                tuple(parameter(f"{name}.lever_m", [0.0, 0.0, 0.0])),
                parameter(f"{name}.acts_on", "finger"),
            )
            for name in ("finger1", "finger2")
        ]
        for sensor in self.sensors:
            if sensor.acts_on not in ("finger", "object"):
                raise ValueError(f"acts_on is {sensor.acts_on!r}; give finger or object")
        # The frame that the predictor takes, in the one that the topic gives: x, y, z, qw, qx, qy, qz.
        here = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        self.local = {name: list(parameter(f"{name}.local_pose", here)) for name in ("gripper", "object")}
        # Where no camera sees the object: its pose in the gripper when it is grasped.
        self.in_grasp = list(parameter("object_in_grasp", here)) if not topics["object"] else None
        self.silent_s = parameter("silent_s", 0.1)

        if self.in_grasp is not None:
            self.get_logger().info("no topic of the object: each grasp begins at object_in_grasp")
        # Whether something is in the fingers: what is not held cannot slip.
        self.grasped = parameter("grasped", True)

        self.grip_n = None
        self.frame = None
        self.waits = True
        self.begun_s = -math.inf
        # Of this machine: that of a simulation stops with it.
        self.clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.last_at = self.clock.now()
        self.seen_s = deque(maxlen=100)
        self.told = set()

        def subscribe(kind, topic, hear):
            if topic:
                self.create_subscription(kind, topic, hear, qos_profile_sensor_data)

        subscribe(WrenchStamped, topics["finger1"], lambda message: self.hear_wrench(0, message))
        subscribe(WrenchStamped, topics["finger2"], lambda message: self.hear_wrench(1, message))
        subscribe(PoseStamped, topics["gripper"], lambda message: self.hear_pose("gripper", message))
        subscribe(PoseStamped, topics["object"], lambda message: self.hear_pose("object", message))
        subscribe(Float64, topics["grip"], self.hear_grip)
        self.create_subscription(Bool, "~/grasp", self.hear_grasp, 10)
        self.create_subscription(String, "~/plan", self.hear_plan, 10)
        self.flags = {name: self.create_publisher(Bool, f"~/{name}", 10) for name in ("slip", "drop", "unsure")}
        self.utilisation = self.create_publisher(Float64, "~/utilisation", 10)
        self.grip = self.create_publisher(Float64, "~/grip", 10)
        self.prediction = self.create_publisher(String, "~/prediction", 10)
        self.create_timer(0.5 * self.silent_s, self.watch, clock=self.clock)

    def tell_once(self, text):
        """A message that comes 250 times a second is no help."""
        if text not in self.told:
            self.told.add(text)
            self.get_logger().warning(text)

    def hear_wrench(self, finger, message):
        force, torque = message.wrench.force, message.wrench.torque
        wrench = [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        if finite(wrench):
            wrench = self.sensors[finger].on_object(wrench)
        else:
            self.tell_once(f"a wrench of finger {finger + 1} is not finite: it counts as not measured")
            wrench = None
        jumps = self.assembler.jumps
        samples = self.assembler.wrench(finger, seconds(message.header.stamp), wrench)
        if self.assembler.jumps > jumps:
            self.get_logger().warning("the clock went back: prediction begins again")
            self.begin()
        self.step(samples)

    def hear_pose(self, body, message):
        position, rotation = message.pose.position, message.pose.orientation
        pose = [position.x, position.y, position.z, rotation.w, rotation.x, rotation.y, rotation.z]
        norm = math.hypot(*pose[3:])
        if not finite(pose) or abs(norm - 1.0) > 0.01:
            self.tell_once(f"a pose of the {body} is none (not finite, or a quaternion whose norm is not 1)")
            return
        # Poses in two frames say nothing of the grasp.
        frame = message.header.frame_id
        if self.frame is None and body == "gripper":
            self.frame = frame
        if self.frame is not None and frame != self.frame:
            self.tell_once(f"the {body}'s poses are in {frame!r}, the gripper's in {self.frame!r}: they are not used")
            return
        if self.local[body] != [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]:
            pose = composed(pose, self.local[body])
        poses = getattr(self.assembler, body)
        self.step(self.assembler.pose(poses, seconds(message.header.stamp), pose))

    def hear_grip(self, message):
        # It has no stamp: it holds from now on.
        if math.isfinite(message.data) and message.data >= 0.0:
            self.grip_n = message.data
        else:
            self.tell_once("a grip command is negative or not finite: the one before holds")

    def hear_grasp(self, message):
        """A grasp begins, or ends: between two nothing is predicted."""
        if message.data:
            self.begin()
        self.grasped = message.data

    def begin(self):
        """With another grasp, or another clock."""
        self.predictor.restart()
        self.waits, self.begun_s = True, -math.inf
        self.seen_s.clear()

    def hear_plan(self, message):
        """A JSON list of segments as stickslip.Predictor takes them; it counts from the newest sample."""
        try:
            self.predictor.set_plan(json.loads(message.data))
        except (TypeError, ValueError) as error:
            self.get_logger().warning(f"the plan is not used: {error}")

    def begin_unseen(self, sample):
        """The stated pose in the grasp stands for that of an object that no camera sees: once, to begin."""
        if self.in_grasp is None or sample.gripper is None or not self.waits:
            return
        # The predictor settles the object for some ticks before it says that it no longer waits.
        if sample.t_s - self.begun_s > 0.1:
            sample.object = composed(sample.gripper, self.in_grasp)
            self.begun_s = sample.t_s

    def step(self, samples):
        for sample in samples if self.grasped else ():
            self.begin_unseen(sample)
            try:
                said = self.predictor.step(
                    sample.t_s, *sample.fingers, sample.gripper, sample.object, self.grip_n
                )
            except ValueError as error:
                self.tell_once(f"a sample is not used: {error}")
                continue
            self.waits = WAITING in said.doubts
            self.watch_rate(sample.t_s)
            self.publish(said)

    def publish(self, said):
        for name, publisher in self.flags.items():
            publisher.publish(Bool(data=getattr(said, name)))
        self.utilisation.publish(Float64(data=said.utilisation))
        if said.holding_grip_n is not None:
            self.grip.publish(Float64(data=said.holding_grip_n))
        self.prediction.publish(String(data=json.dumps(said.to_dict())))
        self.last_at = self.clock.now()

    def watch(self):
        """Where no samples come nothing is predicted: what was published last must not stand as if it were."""
        silent_s = (self.clock.now() - self.last_at).nanoseconds * 1e-9
        if silent_s > self.silent_s:
            self.flags["unsure"].publish(Bool(data=True))

    def watch_rate(self, t_s):
        self.seen_s.append(t_s)
        if len(self.seen_s) == self.seen_s.maxlen:
            times = list(self.seen_s)
            apart_s = sorted(b - a for a, b in zip(times, times[1:]))[len(times) // 2]
            if not 0.75 * PERIOD_S < apart_s < 1.5 * PERIOD_S:
                ask = f"; set every to {round(PERIOD_S / apart_s * self.assembler.settings.every)}"
                ask = ask if apart_s < PERIOD_S else ""
                self.tell_once(f"samples are {apart_s * 1e3:.0f} ms apart, the predictor is made for 4 ms{ask}")


def main():
    rclpy.init()
    node = SlipNode()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
