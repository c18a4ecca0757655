"""A node that waits for what must come, and says what it waits for when it never does."""

import sys
import time

import rclpy
from rclpy.node import Node

# Many times what anything here takes on a busy machine.
PATIENCE_S = 600.0


class Waiting:
    def __init__(self, name):
        rclpy.init()
        self.node = Node(name)

    def until(self, what, true, meanwhile=lambda: None, period_s=0.1):
        """Spins until `true()` is; calls `meanwhile` once a period."""
        began, due = time.monotonic(), 0.0
        while not (found := true()):
            now = time.monotonic()
            if now - began > PATIENCE_S:
                sys.exit(f"waited for {what} for {PATIENCE_S} s")
            if now >= due:
                due = now + period_s
                meanwhile()
            rclpy.spin_once(self.node, timeout_sec=0.02)
        return found

    def end(self):
        self.node.destroy_node()
        rclpy.shutdown()


def stamp_ns(header):
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
