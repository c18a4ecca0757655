"""Follows a live stream with what is not ours, and judges it by the log: stream.py URL LOG.

- `websockets` speaks the subprotocol foxglove.sdk.v1 and subscribes to every topic.
- `mcap-ros2-support` decodes every message by the definition that came with its topic.
- From a topic's subscription on, what came is what the log has of it, message for message, at the same times, to its end.
"""

import asyncio
import json
import re
import struct
import sys
import time
from collections import Counter, defaultdict

import websockets
from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory


async def follow(url):
    """Everything that comes until the server goes: topics, messages by topic, what was dropped."""
    host = re.match(r"http://([^/]+)/", url).group(1)
    channels, streamed, dropped = {}, defaultdict(list), []
    decoders, factory = {}, DecoderFactory()
    async with websockets.connect(
        f"ws://{host}/", subprotocols=["foxglove.sdk.v1"], max_size=None, max_queue=None
    ) as socket:
        assert socket.subprotocol == "foxglove.sdk.v1", socket.subprotocol
        try:
            async for frame in socket:
                if isinstance(frame, bytes):
                    code, number, at = struct.unpack_from("<BIQ", frame)
                    assert code == 1, code
                    streamed[channels[number]["topic"]].append((at, frame[13:], decoders[number](frame[13:])))
                    continue
                said = json.loads(frame)
                if said["op"] == "status" and said["level"] > 0:
                    dropped.append(said["message"])
                if said["op"] != "advertise":
                    continue
                for channel in said["channels"]:
                    number = channel["id"]
                    assert channel["encoding"] == "cdr" and channel["schemaEncoding"] == "ros2msg", channel
                    schema = Schema(
                        id=number, data=channel["schema"].encode(), encoding="ros2msg", name=channel["schemaName"]
                    )
                    channels[number], decoders[number] = channel, factory.decoder_for("cdr", schema)
                new = [{"id": channel["id"], "channelId": channel["id"]} for channel in said["channels"]]
                await socket.send(json.dumps({"op": "subscribe", "subscriptions": new}))
        except websockets.exceptions.ConnectionClosed:
            pass
    return streamed, dropped


def logged(path):
    """Messages by topic, of a log that is whole; the run may still be writing it."""
    for _ in range(600):
        try:
            with open(path, "rb") as file:
                found = defaultdict(list)
                for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
                    found[channel.topic].append((message.log_time, message.data))
                if "/end" in found:
                    return found
        except Exception:  # Not to its end yet.
            pass
        time.sleep(0.1)
    raise SystemExit(f"{path}: has no end")


def main(url, path):
    streamed, dropped = asyncio.run(follow(url))
    assert not dropped, dropped
    log, counts = logged(path), Counter()
    for topic, came in streamed.items():
        # It begins with the newest that there was, and goes on from there to the end.
        came = [(at, data) for at, data, _ in came]
        assert came == log[topic][-len(came) :], (topic, len(came), len(log[topic]))
        counts[topic] = len(came)
    for topic, count in sorted(counts.items()):
        print(f"{count:7d} {topic}")
    absent = [topic for topic in log if topic not in streamed]
    assert not absent, absent


main(*sys.argv[1:])
