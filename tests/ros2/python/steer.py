"""Looks at a fleet by a bridge and steers it, as any node of ROS would: steer.py. Prints what it found as JSON.

- Odometry and tf come at their rates, agree, and belong to a node with a name; what is latched comes to the late.
- A square by cmd_vel, a station by goal_pose, stop and release by their services.
"""

import json
import math
import statistics
import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import BatteryState, JointState
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from common import Waiting, stamp_ns

RELIABLE = QoSProfile(depth=100)
LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
SIDE_M = 0.3
SPEED_M_S = 0.06

waiting = Waiting("operator")
node = waiting.node
came = {}


def listen(kind, topic, qos):
    came[topic] = []
    node.create_subscription(kind, topic, came[topic].append, qos)


def at():
    pose = came["/flotilla/odom"][-1].pose.pose
    return pose.position.x, pose.position.y


def heading():
    q = came["/flotilla/odom"][-1].pose.pose.orientation
    return 2.0 * math.atan2(q.z, q.w)


def median_period_s(stamps):
    stamps = sorted(set(stamps))
    return statistics.median(b - a for a, b in zip(stamps, stamps[1:])) / 1e9


velocity = node.create_publisher(Twist, "/flotilla/cmd_vel", 10)
goal = node.create_publisher(PoseStamped, "/flotilla/goal_pose", 10)
calls = {name: node.create_client(Trigger, f"/flotilla/{name}") for name in ["stop", "hold", "release"]}


def drive(x, y):
    twist = Twist()
    twist.linear.x, twist.linear.y = x, y
    velocity.publish(twist)


# Looked at. What moves is told from the first cycle on, which begins with a target: here to stay.
listen(TFMessage, "/tf", RELIABLE)
listen(Odometry, "/flotilla/odom", qos_profile_sensor_data)
listen(JointState, "/flotilla/joint_states", qos_profile_sensor_data)
listen(BatteryState, "/flotilla/module_1/battery", RELIABLE)
listen(DiagnosticArray, "/diagnostics", RELIABLE)
listen(MarkerArray, "/flotilla/markers", RELIABLE)
least_of = {"/flotilla/odom": 60, "/tf": 60, "/flotilla/joint_states": 60, "/flotilla/module_1/battery": 1}
for topic, least in least_of.items():
    waiting.until(f"{least} messages of {topic}", lambda: len(came[topic]) >= least, lambda: drive(0.0, 0.0))
for topic in ["/diagnostics", "/flotilla/markers"]:
    waiting.until(topic, lambda: came[topic])
# Begun late: the frames within the structure were told long ago.
listen(TFMessage, "/tf_static", LATCHED)
waiting.until("/tf_static", lambda: came["/tf_static"])

odometry = {stamp_ns(message.header): message for message in came["/flotilla/odom"]}
transforms = {}
for message in came["/tf"]:
    for transform in message.transforms:
        transforms.setdefault(transform.child_frame_id, {})[stamp_ns(transform.header)] = transform
shared = [(odometry[at], transform) for at, transform in transforms["flotilla/estimate"].items() if at in odometry]
assert len(shared) >= 10, len(shared)
for message, transform in shared:
    assert (message.header.frame_id, transform.header.frame_id) == ("world", "world")
    p, t = message.pose.pose.position, transform.transform.translation
    q, r = message.pose.pose.orientation, transform.transform.rotation
    assert (p.x, p.y, p.z, q.x, q.y, q.z, q.w) == (t.x, t.y, t.z, r.x, r.y, r.z, r.w)
# The host's clock: two processes of one machine share it.
age_s = time.time() - max(odometry) / 1e9
fixed = {(t.header.frame_id, t.child_frame_id) for t in came["/tf_static"][-1].transforms}
joints = came["/flotilla/joint_states"][-1]
found = {
    "odometry_s": median_period_s(odometry),
    "tf_s": median_period_s(transforms["flotilla/base_link"]),
    "age_s": age_s,
    "frames": sorted(f"{parent}>{child}" for parent, child in fixed),
    "joints": list(joints.name),
    "battery_v": came["/flotilla/module_1/battery"][-1].voltage,
    "diagnosed": [status.name for status in came["/diagnostics"][-1].status],
    "markers": sorted({m.ns for message in came["/flotilla/markers"] for m in message.markers}),
}

# Who publishes: a writer without a node would have no name.
for topic, reliability in [
    ("/tf", QoSReliabilityPolicy.RELIABLE),
    ("/tf_static", QoSReliabilityPolicy.RELIABLE),
    ("/flotilla/odom", QoSReliabilityPolicy.BEST_EFFORT),
    ("/flotilla/joint_states", QoSReliabilityPolicy.BEST_EFFORT),
    ("/flotilla/markers", QoSReliabilityPolicy.RELIABLE),
]:
    named = lambda: [  # noqa: E731
        one for one in node.get_publishers_info_by_topic(topic) if (one.node_namespace, one.node_name) == ("/flotilla", "bridge")
    ]
    (publisher,) = waiting.until(f"the node that publishes {topic}", named)
    assert publisher.qos_profile.reliability == reliability, (topic, publisher.qos_profile.reliability)
    assert len(node.get_publishers_info_by_topic(topic)) == 1, topic

# Steered.


def call(name):
    waiting.until(f"the service {name}", calls[name].service_is_ready)
    answer = calls[name].call_async(Trigger.Request())
    waiting.until(f"an answer of {name}", answer.done)
    return answer.result()


waiting.until("a reader of cmd_vel", lambda: velocity.get_subscription_count() == 1)
begin, corners = at(), []
for forward, left in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]:
    start, turn = at(), heading()
    along = (forward * math.cos(turn) - left * math.sin(turn), forward * math.sin(turn) + left * math.cos(turn))

    def gone():
        x, y = at()
        return (x - start[0]) * along[0] + (y - start[1]) * along[1]

    def speeds():
        """Along the side and across it, by the twist, which is of the body."""
        twist = came["/flotilla/odom"][-1].twist.twist.linear
        return twist.x * forward + twist.y * left, twist.y * forward - twist.x * left

    def swum():
        along_m_s, across_m_s = speeds()
        return gone() >= SIDE_M and along_m_s > 0.04 and abs(across_m_s) < 0.02

    waiting.until("a side of the square", swum, lambda: drive(SPEED_M_S * forward, SPEED_M_S * left))
    corners.append([round(gone(), 3), *(round(speed, 4) for speed in speeds())])
found["corners"] = corners
found["closed_m"] = math.dist(at(), begin)



def swing_rad(since_s, span_s):
    """How far a tail has swung in the last seconds, by stamps; None where there are not so many since `since_s`."""
    joints = [(stamp_ns(message.header) / 1e9, message.position) for message in came["/flotilla/joint_states"]]
    newest_s = joints[-1][0]
    lately = [angles for at_s, angles in joints if at_s >= newest_s - span_s and at_s > since_s]
    covered = newest_s - span_s > since_s and len(lately) >= 10
    return max(max(tail) - min(tail) for tail in zip(*lately)) if covered else None


def newest_s():
    return stamp_ns(came["/flotilla/joint_states"][-1].header) / 1e9


def at_rest(since_s):
    """For longer than between two cycles."""
    swing = swing_rad(since_s, 4.0)
    return swing is not None and swing < 0.1


def moving(since_s):
    swing = swing_rad(since_s, 2.0)
    return swing is not None and swing > 0.5


# Nothing is said any more: the fleet holds.
since_s = newest_s()
waiting.until("tails at rest, after cmd_vel has ended", lambda: at_rest(since_s))

# A station.
target = PoseStamped()
target.header.frame_id = "world"
target.pose.position.x, target.pose.position.y = begin
q = came["/flotilla/odom"][-1].pose.pose.orientation
target.pose.orientation.z, target.pose.orientation.w = q.z, q.w
waiting.until("a reader of goal_pose", lambda: goal.get_subscription_count() == 1)
waiting.until("the station", lambda: math.dist(at(), begin) < 0.03, lambda: goal.publish(target), period_s=5.0)
found["station_m"] = math.dist(at(), begin)

# An emergency stop, while it swims.
since_s = newest_s()
waiting.until("tails that move", lambda: moving(since_s), lambda: drive(SPEED_M_S, 0.0))
stopped = call("stop")
assert stopped.success, stopped.message
since_s = newest_s()
# What is asked for now is refused.
waiting.until("tails at rest, after a stop", lambda: at_rest(since_s), lambda: drive(SPEED_M_S, 0.0))
released = call("release")
assert released.success, released.message
since_s = newest_s()
waiting.until("tails that move, after the release", lambda: moving(since_s), lambda: drive(SPEED_M_S, 0.0))
held = call("hold")
assert held.success, held.message
found["said"] = [stopped.message, released.message, held.message]

print(json.dumps(found))
waiting.end()
