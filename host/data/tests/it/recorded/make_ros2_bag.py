"""Makes ros2.mcap and ros2_kinds.mcap with Foxglove's own library.

pip install mcap mcap-ros2-support; python make_ros2_bag.py
"""

from mcap_ros2.writer import Writer

HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
VECTOR = """
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
QUATERNION = """
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
WRENCH = (
    "std_msgs/Header header\ngeometry_msgs/Wrench wrench"
    + HEADER
    + "=" * 80
    + "\nMSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque"
    + VECTOR
)
TRANSFORMS = (
    "geometry_msgs/TransformStamped[] transforms\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
    + "geometry_msgs/Transform transform"
    + HEADER
    + "=" * 80
    + "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation"
    + VECTOR
    + QUATERNION
)
JOINTS = (
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort" + HEADER
)

POINT = VECTOR.replace("Vector3", "Point")
WRENCH_ALONE = "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque" + VECTOR
POSE_ALONE = "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation" + POINT + QUATERNION
POSE = (
    "std_msgs/Header header\ngeometry_msgs/Pose pose"
    + HEADER
    + "=" * 80
    + "\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation"
    + POINT
    + QUATERNION
)
TRANSFORM = (
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    + HEADER
    + "=" * 80
    + "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation"
    + VECTOR
    + QUATERNION
)


def xyz(x, y, z):
    return {"x": x, "y": y, "z": z}


# Each topic has its own log time: a chunk's last time says which messages are in it.
with open("ros2_kinds.mcap", "wb") as stream:
    writer = Writer(stream, chunk_size=2000)
    wrench = writer.register_msgdef("geometry_msgs/msg/Wrench", WRENCH_ALONE)
    pose = writer.register_msgdef("geometry_msgs/msg/Pose", POSE_ALONE)
    stamped = writer.register_msgdef("geometry_msgs/msg/PoseStamped", POSE)
    transform = writer.register_msgdef("geometry_msgs/msg/TransformStamped", TRANSFORM)
    for k in range(50):
        nanoseconds = k * 4_000_000
        header = {"stamp": {"sec": 1_700_000_000, "nanosec": nanoseconds}, "frame_id": "world"}
        force, torque = xyz(0.25 * k, -20.0, 0.5), xyz(0.0, 0.125, -0.001 * k)
        turned = {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}
        tilted = {"x": 0.6, "y": 0.0, "z": 0.0, "w": 0.8}
        upright = {"x": 0.0, "y": 0.28, "z": 0.0, "w": 0.96}
        block = {"position": xyz(1.0 + 1e-4 * k, 0.0, 0.5), "orientation": turned}
        hand = {"position": xyz(0.5, 2e-4 * k, 0.25), "orientation": tilted}
        rod = {"translation": xyz(-0.125, 0.0, 3e-4 * k), "rotation": upright}
        for place, (topic, kind, message) in enumerate(
            [
                ("/ft", wrench, {"force": force, "torque": torque}),
                ("/hand", pose, hand),
                ("/block", stamped, {"header": header, "pose": block}),
                ("/rod", transform, {"header": header, "child_frame_id": "rod", "transform": rod}),
            ]
        ):
            log_time = 1_700_000_000_000_000_000 + nanoseconds + 1000 * place
            writer.write_message(topic, kind, message, log_time, log_time)
    writer.finish()

with open("ros2.mcap", "wb") as stream:
    writer = Writer(stream)
    wrench = writer.register_msgdef("geometry_msgs/msg/WrenchStamped", WRENCH)
    transforms = writer.register_msgdef("tf2_msgs/msg/TFMessage", TRANSFORMS)
    joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
    grip = writer.register_msgdef("std_msgs/msg/Float64", "float64 data")
    for k in range(50):
        nanoseconds = k * 4_000_000
        stamp = {"sec": 1_700_000_000, "nanosec": nanoseconds}
        log_time = 1_700_000_000_000_000_000 + nanoseconds + 300_000
        header = {"stamp": stamp, "frame_id": "left_finger"}
        force = {"x": 0.01 * k, "y": -20.0, "z": 0.5}
        torque = {"x": 0.001 * k, "y": 0.0, "z": -0.002}
        message = {"header": header, "wrench": {"force": force, "torque": torque}}
        writer.write_message("/ft/left", wrench, message, log_time, log_time)
        bodies = []
        for body, shift in (("hand", 0.0), ("block", 1.0)):
            translation = {"x": shift + 1e-4 * k, "y": 0.0, "z": 0.5}
            rotation = {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}
            bodies.append(
                {
                    "header": {"stamp": stamp, "frame_id": "world"},
                    "child_frame_id": body,
                    "transform": {"translation": translation, "rotation": rotation},
                }
            )
        writer.write_message("/tf", transforms, {"transforms": bodies}, log_time, log_time)
        state = {"header": header, "name": ["jaw"], "position": [0.02], "velocity": [], "effort": [20.0 + k]}
        writer.write_message("/joint_states", joints, state, log_time, log_time)
        writer.write_message("/grip", grip, {"data": 20.0}, log_time, log_time)
    writer.finish()
