"""As much of ROS 2 in one process as the node of the example uses; no middleware, no clock of its own, no threads.

Messages have the fields of geometry_msgs and std_msgs and refuse values of another type, as the real ones do in Python.
What is published is delivered at once.
"""

import sys
import types
from collections import defaultdict


def message(name, **fields):
    """A message class; a field's value is its default, a class among them a message of its own."""

    def init(self, **given):
        for field, default in fields.items():
            setattr(self, field, given.pop(field, default() if isinstance(default, type) else default))
        assert not given, f"{name} has no field {given}"

    def set_checked(self, field, value):
        kind = fields[field] if isinstance(fields[field], type) else type(fields[field])
        assert isinstance(value, kind), f"{name}.{field} is a {kind.__name__}, not {value!r}"
        object.__setattr__(self, field, value)

    return type(name, (), {"__init__": init, "__setattr__": set_checked})


Time = message("Time", sec=0, nanosec=0)
Header = message("Header", stamp=Time, frame_id="")
Vector3 = message("Vector3", x=0.0, y=0.0, z=0.0)
Point = message("Point", x=0.0, y=0.0, z=0.0)
Quaternion = message("Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
Wrench = message("Wrench", force=Vector3, torque=Vector3)
Pose = message("Pose", position=Point, orientation=Quaternion)
WrenchStamped = message("WrenchStamped", header=Header, wrench=Wrench)
PoseStamped = message("PoseStamped", header=Header, pose=Pose)
Bool = message("Bool", data=False)
Float64 = message("Float64", data=0.0)
String = message("String", data="")


class Graph:
    """Topics with their type, who listens and all that was said; the time of the machine; parameters."""

    def __init__(self, parameters):
        self.parameters = dict(parameters)
        self.kinds = {}
        self.listeners = defaultdict(list)
        self.said = defaultdict(list)
        self.timers = []
        self.warnings = []
        self.now_ns = 0

    def kind(self, topic, kind):
        assert self.kinds.setdefault(topic, kind) is kind, f"{topic}: two types"

    def publish(self, topic, message):
        assert isinstance(message, self.kinds[topic]), topic
        self.said[topic].append(message)
        for hear in self.listeners[topic]:
            hear(message)

    def spin(self, node):
        """Ends as by a signal."""
        raise ExternalShutdownException

    def wait(self, seconds):
        """Time of the machine goes on, and timers call."""
        self.now_ns += round(seconds * 1e9)
        for call in self.timers:
            call()


class ExternalShutdownException(Exception):
    pass


class Instant:
    def __init__(self, nanoseconds):
        self.nanoseconds = nanoseconds

    def __sub__(self, other):
        return Instant(self.nanoseconds - other.nanoseconds)


def install(graph, monkeypatch):
    """Puts modules of the names of ROS in place; a node that is made then is in `graph`."""

    class Clock:
        def __init__(self, *, clock_type):
            assert clock_type == "steady"

        def now(self):
            return Instant(graph.now_ns)

    class Logger:
        def info(self, text):
            pass

        def warning(self, text):
            graph.warnings.append(text)

    class Publisher:
        def __init__(self, topic):
            self.topic = topic

        def publish(self, message):
            graph.publish(self.topic, message)

    class Parameter:
        def __init__(self, value):
            self.value = value

    class Node:
        def __init__(self, name):
            self.name = name
            self.declared = set()

        def resolved(self, topic):
            return topic.replace("~", f"/{self.name}")

        def declare_parameter(self, name, value):
            assert name not in self.declared, f"{name} is declared twice"
            self.declared.add(name)
            given = graph.parameters.get(name, value)
            assert type(given) is type(value), f"parameter {name}: {given!r}"
            return Parameter(given)

        def create_subscription(self, kind, topic, callback, qos):
            graph.kind(self.resolved(topic), kind)
            graph.listeners[self.resolved(topic)].append(callback)

        def create_publisher(self, kind, topic, qos):
            graph.kind(self.resolved(topic), kind)
            return Publisher(self.resolved(topic))

        def create_timer(self, period_s, callback, *, clock):
            graph.timers.append(callback)

        def destroy_node(self):
            pass

        def get_logger(self):
            return Logger()

    def module(name, **content):
        made = types.ModuleType(name)
        vars(made).update(content)
        monkeypatch.setitem(sys.modules, name, made)

    module("rclpy", init=lambda: None, spin=graph.spin, try_shutdown=lambda: None)
    module("rclpy.executors", ExternalShutdownException=ExternalShutdownException)
    module("rclpy.clock", Clock=Clock, ClockType=types.SimpleNamespace(STEADY_TIME="steady"))
    module("rclpy.node", Node=Node)
    module("rclpy.qos", qos_profile_sensor_data="sensor data")
    module("geometry_msgs")
    module("geometry_msgs.msg", PoseStamped=PoseStamped, WrenchStamped=WrenchStamped)
    module("std_msgs")
    module("std_msgs.msg", Bool=Bool, Float64=Float64, String=String)
