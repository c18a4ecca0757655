"""Odometry and tf by Cyclone DDS, without any ROS: listen_by_cyclone.py DOMAIN. Prints what it found as JSON.

Types are declared here as the wire has them, and named as DDS has those of ROS.
"""

import dataclasses
import json
import sys
import time
import types

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int32, sequence, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

PATIENCE_S = 600.0


def declared(name, **fields):
    """A type of ROS: package/Name, and its fields in order."""
    package, name = name.split("/")
    typename = f"{package}::msg::dds_::{name}_"
    made = types.new_class(name, (IdlStruct,), {"typename": typename}, lambda body: body.update(__annotations__=fields))
    return dataclasses.dataclass(made)


Time = declared("builtin_interfaces/Time", sec=int32, nanosec=uint32)
Header = declared("std_msgs/Header", stamp=Time, frame_id=str)
Vector3 = declared("geometry_msgs/Vector3", x=float64, y=float64, z=float64)
Quaternion = declared("geometry_msgs/Quaternion", x=float64, y=float64, z=float64, w=float64)
Transform = declared("geometry_msgs/Transform", translation=Vector3, rotation=Quaternion)
TransformStamped = declared("geometry_msgs/TransformStamped", header=Header, child_frame_id=str, transform=Transform)
TFMessage = declared("tf2_msgs/TFMessage", transforms=sequence[TransformStamped])
Pose = declared("geometry_msgs/Pose", position=Vector3, orientation=Quaternion)
PoseWithCovariance = declared("geometry_msgs/PoseWithCovariance", pose=Pose, covariance=array[float64, 36])
Twist = declared("geometry_msgs/Twist", linear=Vector3, angular=Vector3)
TwistWithCovariance = declared("geometry_msgs/TwistWithCovariance", twist=Twist, covariance=array[float64, 36])
Odometry = declared(
    "nav_msgs/Odometry", header=Header, child_frame_id=str, pose=PoseWithCovariance, twist=TwistWithCovariance
)

participant = DomainParticipant(int(sys.argv[1]))
best_effort = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(5))
reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(100))
latched = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1))
readers = {
    "odometry": DataReader(participant, Topic(participant, "rt/flotilla/odom", Odometry), qos=best_effort),
    "tf": DataReader(participant, Topic(participant, "rt/tf", TFMessage), qos=reliable),
    "tf_static": DataReader(participant, Topic(participant, "rt/tf_static", TFMessage), qos=latched),
}
came = {name: [] for name in readers}
began = time.monotonic()
while len(came["odometry"]) < 30 or len(came["tf"]) < 30 or not came["tf_static"]:
    if time.monotonic() - began > PATIENCE_S:
        sys.exit(f"waited for {PATIENCE_S} s; there came {({name: len(all) for name, all in came.items()})}")
    for name, reader in readers.items():
        came[name].extend(reader.take(N=100))
    time.sleep(0.01)


def stamp(header):
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


odometry = {stamp(message.header): message for message in came["odometry"]}
agree = 0
for transform in (one for message in came["tf"] for one in message.transforms):
    message = odometry.get(stamp(transform.header))
    if transform.child_frame_id == "flotilla/estimate" and message:
        assert dataclasses.astuple(message.pose.pose.position) == dataclasses.astuple(transform.transform.translation)
        assert dataclasses.astuple(message.pose.pose.orientation) == dataclasses.astuple(transform.transform.rotation)
        agree += 1
assert agree >= 5, agree
fixed = [one.child_frame_id for one in came["tf_static"][0].transforms]
print(json.dumps({"agree": agree, "child": came["odometry"][0].child_frame_id, "fixed": fixed}))
