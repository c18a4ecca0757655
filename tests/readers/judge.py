"""Reads a log with what is not ours: judge.py LOG TABLES.

- mcap-ros2-support and rosbags decode every message, to the same values.
- The definitions in it are ROS 2's own, where a message is one of ROS 2.
- The odometry that they decode is the one in the exported tables, number for number.
- `rerun mcap convert` takes it.
"""

import csv
import math
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

COLUMNS = {
    "header_frame_id": lambda m: m.header.frame_id,
    "child_frame_id": lambda m: m.child_frame_id,
    "pose_pose_position_x_m": lambda m: m.pose.pose.position.x,
    "pose_pose_position_y_m": lambda m: m.pose.pose.position.y,
    "pose_pose_position_z_m": lambda m: m.pose.pose.position.z,
    "pose_pose_orientation_x": lambda m: m.pose.pose.orientation.x,
    "pose_pose_orientation_y": lambda m: m.pose.pose.orientation.y,
    "pose_pose_orientation_z": lambda m: m.pose.pose.orientation.z,
    "pose_pose_orientation_w": lambda m: m.pose.pose.orientation.w,
    "twist_twist_linear_x_m_s": lambda m: m.twist.twist.linear.x,
    "twist_twist_linear_y_m_s": lambda m: m.twist.twist.linear.y,
    "twist_twist_linear_z_m_s": lambda m: m.twist.twist.linear.z,
    "twist_twist_angular_x_rad_s": lambda m: m.twist.twist.angular.x,
    "twist_twist_angular_y_rad_s": lambda m: m.twist.twist.angular.y,
    "twist_twist_angular_z_rad_s": lambda m: m.twist.twist.angular.z,
} | {
    f"{part}_covariance_{k}": (lambda m, part=part, k=k: getattr(m, part).covariance[k])
    for part in ("pose", "twist")
    for k in range(36)
}


def same(a, b):
    """Whether two decoded values are the same, a NaN like another."""
    if hasattr(b, "__dataclass_fields__"):
        # Without constants, which only one of the two has.
        names = [name for name in b.__dataclass_fields__ if name != name.upper() and not name.startswith("__")]
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, (bytes, bytearray)):
        return bytes(a) == bytes(b)
    if hasattr(b, "__len__") and not isinstance(b, str):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b))
    if isinstance(a, float) and math.isnan(a):
        return math.isnan(b)
    return a == b


def definitions(log):
    """Definitions of ROS 2's own messages, against ROS 2's own."""
    store = get_typestore(Stores.ROS2_KILTED)
    compared = set()
    with open(log, "rb") as file:
        for schema in make_reader(file).get_summary().schemas.values():
            assert schema.encoding == "ros2msg", schema
            for name, fields in get_types_from_msg(schema.data.decode(), schema.name).items():
                if name.startswith("flotilla_msgs/"):
                    continue
                own, ros = fields, store.fielddefs[name]
                assert list(own[1]) == list(ros[1]), f"{name}: {own[1]} is not {ros[1]}"
                assert sorted(map(str, own[0])) == sorted(map(str, ros[0])), f"{name}: constants {own[0]}, {ros[0]}"
                compared.add(name)
    return compared


def main(log, tables):
    compared = definitions(log)
    wanted = {
        "tf2_msgs/msg/TFMessage",
        "sensor_msgs/msg/BatteryState",
        "diagnostic_msgs/msg/DiagnosticArray",
        "visualization_msgs/msg/MarkerArray",
    }
    assert wanted <= compared, wanted - compared

    # In the order of the file, every check sum looked at.
    decoded, counts = {}, Counter()
    with open(log, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, value in reader.iter_decoded_messages(log_time_order=False):
            counts[channel.topic] += 1
            decoded.setdefault(channel.topic, []).append((message.log_time, value))
        statistics = reader.get_summary().statistics
    assert sum(counts.values()) == statistics.message_count > 0

    again = Counter()
    with AnyReader([Path(log)]) as reader:
        for connection, time, data in reader.messages():
            value = reader.deserialize(data, connection.msgtype)
            known_time, known = decoded[connection.topic][again[connection.topic]]
            assert time == known_time, (connection.topic, time, known_time)
            assert same(known, value), (connection.topic, time, known, value)
            again[connection.topic] += 1
    assert again == counts, (again, counts)

    odometry = [topic for topic in decoded if topic.endswith("/odom")]
    assert odometry
    for topic in odometry:
        with open(Path(tables) / f"{topic.strip('/').replace('/', '_')}.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == len(decoded[topic]) > 0, (topic, len(rows))
        assert set(rows[0]) == set(COLUMNS) | {"t_s", "header_stamp_s"}, set(rows[0]) ^ set(COLUMNS)
        for row, (time, value) in zip(rows, decoded[topic]):
            stamp = value.header.stamp
            assert row["t_s"] == f"{time // 10**9}.{time % 10**9:09}", row
            assert row["header_stamp_s"] == f"{stamp.sec}.{stamp.nanosec:09}", row
            for column, of in COLUMNS.items():
                number = of(value)
                cell = row[column] if isinstance(number, str) else float(row[column])
                assert cell == number, (topic, column, cell, number)
    exported = {path.stem for path in Path(tables).glob("*.csv")}
    assert exported == {topic.strip("/").replace("/", "_") for topic in counts}, exported

    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "log.rrd"
        rerun = Path(sys.executable).parent / "rerun"
        said = subprocess.run(
            [rerun, "mcap", "convert", log, "-o", target], capture_output=True, text=True, check=False
        )
        assert said.returncode == 0 and target.stat().st_size > 100_000, said
        assert "ERROR" not in said.stderr, said.stderr

    for topic, count in sorted(counts.items()):
        print(f"{count:>7} {topic}")


main(*sys.argv[1:])
