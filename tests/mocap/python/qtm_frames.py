"""Prints frames as the vendor's qtm-rt reads them: COUNT PORT 6d|6dres|6deuler [udp]"""

import asyncio
import json
import math
import sys
import xml.etree.ElementTree as ElementTree

import qtm_rt


def quaternion(m):
    """w, x, y, z of a rotation matrix given column by column."""
    w = math.sqrt(max(0.0, 1 + m[0] + m[4] + m[8])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + m[0] - m[4] - m[8])) / 2, m[5] - m[7])
    y = math.copysign(math.sqrt(max(0.0, 1 - m[0] + m[4] - m[8])) / 2, m[6] - m[2])
    z = math.copysign(math.sqrt(max(0.0, 1 - m[0] - m[4] + m[8])) / 2, m[1] - m[3])
    return [w, x, y, z]


async def main():
    count, port, component = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    connection = await qtm_rt.connect("127.0.0.1", port=port)
    xml = await connection.get_parameters(parameters=["6d"])
    names = [name.text for name in ElementTree.fromstring(xml).findall("*/Body/Name")]
    assert await connection.byte_order() == b"Byte order is little endian"
    done = asyncio.Event()
    printed = 0

    def on_packet(packet):
        nonlocal printed
        if done.is_set():
            return
        read = packet.get_6d() if component == "6d" else packet.get_6d_residual()
        bodies = {
            name: list(position) + quaternion(rotation.matrix)
            for name, (position, rotation, *_) in zip(names, read[1])
            if not math.isnan(position.x)
        }
        line = {"number": packet.framenumber, "captured_us": packet.timestamp, "bodies": bodies}
        print(json.dumps(line), flush=True)
        printed += 1
        if printed == count:
            done.set()

    await connection.stream_frames(components=[component], on_packet=on_packet)
    await done.wait()
    connection.disconnect()


asyncio.run(main())
