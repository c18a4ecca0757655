"""A driver of ROS over a motion capture, as laboratories run one: drive_poses.py KIND VRPN_PORT [COUNT].

Reads bodies by libmotioncapture and publishes each as KIND: `pose` on /BODY/pose, `odom` on /BODY/odom, `tf` as a child of `lab` on /tf.
Names in ROS have no hyphen: `module-1` is module_1. Runs until it is ended.
"""

import sys
import threading

import motioncapture
import rclpy
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from tf2_msgs.msg import TFMessage

kind, port = sys.argv[1], sys.argv[2]
rclpy.init()
node = Node("driver")
publishers = {}


def publisher(kind, topic):
    if topic not in publishers:
        publishers[topic] = node.create_publisher(kind, topic, qos_profile_sensor_data)
    return publishers[topic]


def fill(position, attitude, body):
    position.x, position.y, position.z = (float(x) for x in body.position)
    r = body.rotation
    attitude.w, attitude.x, attitude.y, attitude.z = r.w, r.x, r.y, r.z


def publish(name, body):
    name = name.replace("-", "_")
    stamp = node.get_clock().now().to_msg()
    if kind == "tf":
        transform = TransformStamped(child_frame_id=name)
        transform.header.stamp, transform.header.frame_id = stamp, "lab"
        fill(transform.transform.translation, transform.transform.rotation, body)
        # A frame of another tree, which is no body.
        other = TransformStamped(child_frame_id="camera")
        other.header.stamp, other.header.frame_id = stamp, "rig"
        publisher(TFMessage, "/tf").publish(TFMessage(transforms=[other, transform]))
        return
    message = Odometry() if kind == "odom" else PoseStamped()
    message.header.stamp, message.header.frame_id = stamp, "lab"
    pose = message.pose.pose if kind == "odom" else message.pose
    fill(pose.position, pose.orientation, body)
    publisher(type(message), f"/{name}/{kind}").publish(message)


def follow():
    source = motioncapture.connect("vrpn", {"hostname": f"127.0.0.1:{port}"})
    last = {}
    while rclpy.ok():
        source.waitForNextFrame()
        for name, body in source.rigidBodies.items():
            # The client shows a body again until it has moved.
            seen = tuple(body.position)
            if last.get(name) != seen:
                last[name] = seen
                publish(name, body)


threading.Thread(target=follow, daemon=True).start()
rclpy.spin(node)
