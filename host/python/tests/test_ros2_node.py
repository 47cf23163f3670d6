"""The ROS 2 node of the examples, in a stub of ROS: what it publishes is what the predictor says of the trial."""

import importlib.util
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import ros_stub as ros

import stickslip
from conftest import row_of, samples

FILE = Path(__file__).parents[1] / "examples" / "ros2_slip_node.py"
# Of the robot's clock, which counts from 1970.
EPOCH_S = 1_700_000_000


class Bench:
    """A node in a graph, and the trial that is played to it."""

    def __init__(self, data, trial, folder, monkeypatch, **parameters):
        path = folder / "rig"
        if not path.exists():
            data.write(path)
        of = row_of(data, trial)
        assert of["pusher"] is None
        self.trial = samples(data, trial)
        given = {
            "rig": str(path / "dataset.toml"),
            "object": of["object"],
            "primitive": of["primitive"],
            "grip_n": float(of["grip_n"]),
            "topics.object": "/object/pose",
            "finger1.acts_on": "object",
            "finger2.acts_on": "object",
        }
        self.graph = ros.Graph(given | parameters)
        ros.install(self.graph, monkeypatch)
        spec = importlib.util.spec_from_file_location("ros2_slip_node", FILE)
        self.module = importlib.util.module_from_spec(spec)
        # Data classes look their module up.
        monkeypatch.setitem(sys.modules, "ros2_slip_node", self.module)
        spec.loader.exec_module(self.module)
        self.node = self.module.SlipNode()
        # What the node passes to its predictor.
        self.stepped = []
        step = self.node.predictor.step
        self.node.predictor.step = lambda *parts: self.stepped.append(parts) or step(*parts)
        # What the predictor says of the same samples.
        self.own = stickslip.Predictor(
            data, of["object"], primitive=of["primitive"], grip_n=float(of["grip_n"])
        )

    def header(self, t_s, frame="world"):
        sec, nanosec = divmod(EPOCH_S * 10**9 + round(t_s * 1e9), 10**9)
        return ros.Header(stamp=ros.Time(sec=sec, nanosec=nanosec), frame_id=frame)

    def wrench(self, finger, t_s, six):
        force, torque = (ros.Vector3(**dict(zip("xyz", map(float, part)))) for part in (six[:3], six[3:]))
        message = ros.WrenchStamped(header=self.header(t_s, "pad"), wrench=ros.Wrench(force=force, torque=torque))
        self.graph.publish(f"/finger{finger}/wrench", message)

    def pose(self, body, t_s, seven, frame="world"):
        x, y, z, qw, qx, qy, qz = map(float, seven)
        pose = ros.Pose(position=ros.Point(x=x, y=y, z=z), orientation=ros.Quaternion(x=qx, y=qy, z=qz, w=qw))
        self.graph.publish(f"/{body}/pose", ros.PoseStamped(header=self.header(t_s, frame), pose=pose))

    def messages(self, sample):
        """What is published of a sample, each with its name."""
        t_s, grip_n = sample["t_s"], sample["grip_n"]
        out = []
        if grip_n is not None:
            grip = ros.Float64(data=float(grip_n))
            out.append(("grip", lambda: self.graph.publish("/gripper/grip_command", grip)))
        for body in ("gripper", "object"):
            if sample[body] is not None:
                out.append((body, lambda body=body: self.pose(body, t_s, sample[body])))
        for finger in (1, 2):
            wrench = sample[f"finger{finger}"]
            if wrench is not None:
                out.append((f"finger{finger}", lambda finger=finger, wrench=wrench: self.wrench(finger, t_s, wrench)))
        return out

    def play(self, some, but=(), delay_s=None):
        """Publishes samples in order of time; each name's messages come later by `delay_s`."""
        queue = []
        for sample in some:
            for order, (name, send) in enumerate(self.messages(sample)):
                if name not in but:
                    queue.append((sample["t_s"] + (delay_s or {}).get(name, 0.0), order, send))
        for _, _, send in sorted(queue, key=lambda one: one[:2]):
            send()

    def said(self, name):
        return [message.data for message in self.graph.said[f"/stickslip/{name}"]]

    def predictions(self):
        return [json.loads(text) for text in self.said("prediction")]

    def expected(self, some):
        return [self.own.step(**{**sample, "t_s": EPOCH_S + sample["t_s"]}) for sample in some]


@pytest.fixture
def bench(lifts, tmp_path, monkeypatch):
    def make(trial=None, **parameters):
        return Bench(lifts, trial or lost(lifts), tmp_path, monkeypatch, **parameters)

    return make


def lost(lifts):
    """A lift in which the object slips and is lost."""
    for row in lifts.trials:
        up = {span.flag for span in stickslip.replay(lifts, row["trial"]).flags}
        if "drop" in up and "slip, finger 1" in up:
            return row["trial"]
    raise AssertionError("no lift in which the object is lost")


def test_what_is_published_is_what_the_predictor_says(bench):
    one = bench()
    one.play(one.trial)
    expected = one.expected(one.trial)
    assert len(expected) > 200
    for name in ("slip", "drop", "unsure"):
        assert one.said(name) == [getattr(said, name) for said in expected], name
    assert any(one.said("slip")) and any(one.said("drop")) and not all(one.said("unsure"))
    assert one.said("utilisation") == [said.utilisation for said in expected]
    assert one.said("grip") == [s.holding_grip_n for s in expected if s.holding_grip_n is not None]
    assert len(one.said("grip")) > 100
    for text, said in zip(one.predictions(), expected, strict=True):
        assert text == json.loads(json.dumps(said.to_dict()))
    assert one.node.predictor.hash == one.own.hash and one.graph.warnings == []


def test_with_the_plan_on_its_topic_the_bits_are_those_of_replay(bench, lifts):
    trial = lost(lifts)
    one = bench(trial)
    report = stickslip.replay(lifts, trial)
    plan = ros.String(data=json.dumps(report.to_dict()["plan"]))
    one.graph.publish("/stickslip/plan", plan)
    one.play(one.trial)
    assert one.node.predictor.hash == report.hash
    one.graph.publish("/stickslip/plan", ros.String(data="[{}]"))
    one.graph.publish("/stickslip/plan", ros.String(data="7"))
    assert len(one.graph.warnings) == 2 and "missing field" in one.graph.warnings[0]


@pytest.mark.parametrize(
    "delay_s",
    [
        {"finger2": 0.006},
        {"finger1": 0.0035, "gripper": 0.002},
        {"gripper": 0.005, "object": 0.003},
        {"finger1": 0.001, "finger2": 0.005, "gripper": 0.0055, "object": 0.0045},
    ],
)
def test_messages_that_come_in_another_order_make_the_same_samples(bench, delay_s):
    one = bench()
    # A command has no stamp: it goes with the sample that is stepped next.
    one.play(one.trial, delay_s={"grip": max(delay_s.values()), **delay_s})
    expected = one.expected(one.trial)
    # The last samples wait for what ended with the trial.
    assert len(expected) - 3 <= len(one.stepped) <= len(expected)
    # A pose is waited for once its topic has shown that it comes every tick: not in the first ticks.
    begun = 5 if {"gripper", "object"} & delay_s.keys() else 0
    for sample, (t_s, *parts) in list(zip(one.trial, one.stepped))[begun:]:
        assert t_s == EPOCH_S + sample["t_s"]
        for name, part in zip(("finger1", "finger2", "gripper", "object", "grip_n"), parts):
            assert np.array_equal(part, sample[name]), (t_s, name)
    if begun == 0:
        own = [json.loads(json.dumps(said.to_dict())) for said in expected]
        assert one.predictions() == own[: len(one.stepped)]


def test_samples_of_one_finger_that_overtake_each_other_are_put_in_order_or_left_out(bench):
    one = bench()
    swapped = []
    for a, b in zip(one.trial[0:200:2], one.trial[1:200:2]):
        (ga, oa, fa1, fa2), (gb, ob, fb1, fb2) = ([m for m in one.messages(s) if m[0] != "grip"] for s in (a, b))
        # Finger 1 of both first, the later one before the earlier; finger 2 in order.
        swapped += [ga, oa, gb, ob, fb1, fa1, fa2, fb2]
    for _, send in swapped:
        send()
    got = [said["t_s"] for said in one.predictions()]
    assert got == [EPOCH_S + sample["t_s"] for sample in one.trial[:200]]
    assert one.node.assembler.late == 0
    # One that comes when its sample was stepped long ago changes nothing.
    before = one.node.predictor.hash
    one.wrench(1, one.trial[100]["t_s"], one.trial[100]["finger1"])
    assert one.node.assembler.late == 1 and one.node.predictor.hash == before


def test_a_finger_whose_wrench_is_far_too_late_is_missing_and_the_flags_are_unsure(bench):
    one = bench()
    one.play(one.trial[:150], delay_s={"finger2": 0.05})
    said = one.predictions()
    assert len(said) > 130
    assert all("doubt: one finger's wrench missing" in p["doubts"] for p in said[5:-3])
    assert all(one.said("unsure")[5:-3])
    assert one.node.assembler.late > 100
    # Without a sensor in the finger nothing is waited for.
    alone = bench(**{"topics.finger2": ""})
    for sample in alone.trial[:50]:
        before = len(alone.said("slip"))
        alone.play([sample], but=["finger2"])
        assert len(alone.said("slip")) == before + 1


def test_without_an_object_pose_prediction_waits_or_begins_at_the_stated_grasp(bench):
    blind = bench()
    blind.play(blind.trial[:100], but=["object"])
    assert all("doubt: waiting for the object's pose" in p["doubts"] for p in blind.predictions())
    assert all(blind.said("unsure"))

    first = blind.trial[0]
    assert first["gripper"][3:] == pytest.approx([1, 0, 0, 0], abs=1e-2)
    inside = [*(first["object"][:3] - first["gripper"][:3]), *first["object"][3:]]
    stated = bench(**{"topics.object": "", "object_in_grasp": [float(x) for x in inside]})
    stated.play(stated.trial, but=["object"])
    said = stated.predictions()
    assert len(said) == len(stated.trial)
    assert not any("doubt: waiting for the object's pose" in p["doubts"] for p in said[50:])
    assert any(stated.said("slip")) and any(stated.said("drop"))
    # After a gap it is stated again.
    again = bench(**{"topics.object": "", "object_in_grasp": [float(x) for x in inside]})
    again.play(again.trial[:60], but=["object"])
    again.play([{**s, "t_s": s["t_s"] + 0.5} for s in again.trial[60:120]], but=["object"])
    assert not any("doubt: waiting for the object's pose" in p["doubts"] for p in again.predictions()[-20:])


def test_a_gripper_pose_stands_for_20_ms_and_an_object_pose_is_used_once(bench):
    one = bench()
    one.play(one.trial[:100])
    one.play(one.trial[100:150], but=["gripper"])
    said = one.predictions()[100:]
    # It stands in the samples that are no more than 20 ms later.
    unusable = ["doubt: unusable sample" in p["doubts"] for p in said]
    assert unusable[:5] == [False] * 5 and all(unusable[6:25])
    assert all(one.said("unsure")[107:])

    other = bench()
    # A camera of 62.5 Hz, whose poses come 20 ms late; then one that is 50 ms late.
    for i, sample in enumerate(other.trial[:120]):
        if i % 4 == 0 and i >= 15:
            late = other.trial[i - 5 if i < 60 else i - 13]
            other.pose("object", late["t_s"], late["object"])
        other.play([sample], but=["object"])
    seen = [object for *_, object, _ in other.stepped]
    given = [i for i, pose in enumerate(seen) if pose is not None]
    assert given == list(range(16, 60, 4))
    assert all(np.array_equal(seen[i], other.trial[i - 5]["object"]) for i in given)


def test_a_clock_that_goes_back_begins_the_prediction_anew(bench):
    one = bench()
    one.play(one.trial)
    count = len(one.predictions())
    # The simulation is reset: the same trial again, from its beginning.
    one.play(one.trial)
    assert any("clock went back" in text for text in one.graph.warnings)
    again = one.predictions()[count:]
    assert len(again) >= len(one.trial) - 2
    assert any(p["slip"] for p in again) and any(p["drop"] for p in again)
    assert not any(p["unsure"] for p in again[50:100])
    # Forward: a pause. The grasp is seen anew.
    count = len(one.predictions())
    one.play([{**sample, "t_s": sample["t_s"] + 3600.0} for sample in one.trial[:150]])
    later = one.predictions()[count:]
    assert len(later) == 150 and not any(p["unsure"] for p in later[50:])
    # A single stamp from far ahead is such a pause, and a jump back: what follows is predicted.
    count = len(one.predictions())
    one.wrench(1, 9000.0, one.trial[0]["finger1"])
    one.play([{**sample, "t_s": sample["t_s"] + 3700.0} for sample in one.trial[:150]])
    assert not any(p["unsure"] for p in one.predictions()[count:][60:])


def test_numbers_that_are_none_and_poses_of_other_frames_are_not_used_and_said_once(bench):
    one = bench()
    one.play(one.trial[:50])
    nothing = np.full(6, np.nan)
    bad_pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    for sample in one.trial[50:60]:
        one.pose("gripper", sample["t_s"], sample["gripper"])
        one.pose("object", sample["t_s"], bad_pose)
        one.pose("object", sample["t_s"], sample["object"], frame="camera")
        one.wrench(1, sample["t_s"], nothing)
        one.wrench(2, sample["t_s"], sample["finger2"])
        one.graph.publish("/gripper/grip_command", ros.Float64(data=-1.0))
        one.graph.publish("/gripper/grip_command", ros.Float64(data=math.nan))
    said = one.predictions()[50:]
    assert len(said) == 10
    assert all("doubt: one finger's wrench missing" in p["doubts"] for p in said[1:])
    assert len(one.graph.warnings) == 4, one.graph.warnings
    assert any("'camera'" in text and "'world'" in text for text in one.graph.warnings)


def test_where_no_samples_come_unsure_is_published(bench):
    one = bench()
    one.play(one.trial[:100])
    one.graph.wait(0.05)
    assert len(one.said("unsure")) == 100 and one.said("unsure")[-1] is False
    one.graph.wait(0.06)
    assert len(one.said("unsure")) == 101 and one.said("unsure")[-1] is True


def test_between_two_grasps_nothing_is_predicted_and_each_begins_anew(bench):
    one = bench(grasped=False)
    one.play(one.trial[:50])
    one.graph.wait(0.2)
    assert one.said("slip") == [] and one.said("unsure") == [True]
    for count in (1, 2):
        one.graph.publish("/stickslip/grasp", ros.Bool(data=True))
        some = one.trial[200 * count : 200 * count + 100]
        one.play(some)
        fresh = stickslip.Predictor(one.graph.parameters["rig"], one.graph.parameters["object"], grip_n=1.0)
        own = [fresh.step(**{**sample, "t_s": EPOCH_S + sample["t_s"]}) for sample in some]
        assert len(one.said("slip")) == 100 * count
        assert one.predictions()[-100]["flags"] == own[0].flags
        assert [p["sag_m"] for p in one.predictions()[-100:][:2]] == [said.sag_m for said in own[:2]]
        one.graph.publish("/stickslip/grasp", ros.Bool(data=False))
        one.play(one.trial[200 * count + 100 : 200 * count + 200])
        assert len(one.said("slip")) == 100 * count


def test_a_sensor_in_its_own_axes_that_feels_the_reaction_is_turned_into_what_the_predictor_takes(bench):
    straight = bench()
    straight.play(straight.trial)
    turn = [math.cos(0.4), 0.0, math.sin(0.4) * 0.6, math.sin(0.4) * 0.8]
    lever = [0.01, 0.02, -0.03]
    fingers = {f"finger{k}.{name}": value for k in (1, 2) for name, value in
               {"quaternion_wxyz": turn, "lever_m": lever, "acts_on": "finger"}.items()}
    one = bench(**fingers)
    matrix = np.array([one.module.turned(turn, axis) for axis in np.eye(3)])

    def felt(wrench):
        # About the sensor's origin, which lies at the lever; in its axes; of the object on it.
        force, torque = wrench[:3], wrench[3:] - np.cross(lever, wrench[:3])
        return -np.concatenate([matrix @ force, matrix @ torque])

    own = [{**s, "finger1": felt(s["finger1"]), "finger2": felt(s["finger2"])} for s in one.trial]
    one.play(own)
    for name in ("slip", "drop", "unsure"):
        assert np.mean(np.array(one.said(name)) == np.array(straight.said(name))) > 0.99, name
    assert np.allclose(one.said("utilisation"), straight.said("utilisation"), atol=0.02)


def test_a_frame_of_the_robot_is_turned_into_the_grippers(bench):
    straight = bench()
    straight.play(straight.trial[:150])
    # The robot gives its flange, 0.1 m behind, its axes turned by a quarter about X.
    half = math.sqrt(0.5)
    local = [0.0, 0.0, 0.1, half, half, 0.0, 0.0]
    one = bench(**{"gripper.local_pose": local})
    inverse = [*one.module.turned([half, -half, 0.0, 0.0], [0.0, 0.0, -0.1]), half, -half, 0.0, 0.0]
    one.play([{**s, "gripper": one.module.composed(s["gripper"], inverse)} for s in one.trial[:150]])
    assert np.allclose(one.said("utilisation"), straight.said("utilisation"), atol=0.02)
    assert one.predictions()[-1]["pose"] == pytest.approx(straight.predictions()[-1]["pose"], abs=1e-4)


def test_a_sensor_of_1_khz_is_used_every_fourth_time_or_said(bench):
    def fast(one):
        for sample in one.trial[:110]:
            for k in range(4):
                t_s = sample["t_s"] + 0.001 * k
                one.play([{**sample, "t_s": t_s, "object": sample["object"] if k == 0 else None}])

    one = bench(every=4)
    fast(one)
    assert [p["t_s"] for p in one.predictions()] == [EPOCH_S + s["t_s"] for s in one.trial[:110]]
    assert one.graph.warnings == []
    other = bench()
    fast(other)
    assert other.graph.warnings == ["samples are 1 ms apart, the predictor is made for 4 ms; set every to 4"]


def test_a_signal_ends_the_program_without_a_trace(bench):
    one = bench()
    one.graph.kinds.clear()
    one.module.main()


def test_a_parameter_that_cannot_be_is_refused_when_the_node_starts(bench):
    with pytest.raises(ValueError, match="acts_on is 'gripper'; give finger or object"):
        bench(**{"finger1.acts_on": "gripper"})
    with pytest.raises(stickslip.DataError, match="no such object in dataset.toml"):
        bench(object="cup")


def test_the_parameters_are_those_of_the_manual(bench):
    page = (Path(__file__).parents[3] / "docs" / "python.md").read_text()
    declared = bench().node.declared
    missing = [name for name in sorted(declared) if f"`{name.replace('finger2.', 'finger1.')}`" not in page]
    assert missing == []
