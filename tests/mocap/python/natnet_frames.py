"""Prints frames as the package natnet reads them: COUNT COMMAND_PORT DATA_PORT multicast|unicast [BITSTREAM]"""

import json
import struct
import sys
import time

from natnet import NatNetClient
from natnet.version import Version

count, command_port, data_port = (int(argument) for argument in sys.argv[1:4])
client = NatNetClient(
    command_port=command_port,
    data_port=data_port,
    use_multicast=sys.argv[4] == "multicast",
)
names = {}
frames = []
client.on_data_description_received_event.handlers.append(
    lambda described: names.update({body.id_num: body.name for body in described.rigid_bodies})
)
client.on_data_frame_received_event.handlers.append(frames.append)
with client:
    if len(sys.argv) > 5:
        client.protocol_version = Version(*(int(number) for number in sys.argv[5].split(".")))
        # The client reads frames that came before the server's answer by the new layout, and fails on them.
        for _ in range(1000):
            try:
                client.update_sync()
                break
            except struct.error:
                pass
    while not names:
        client.request_modeldef()
        time.sleep(0.05)
        client.update_sync()
    frames.clear()
    printed = 0
    while printed < count:
        client.update_sync()
        for frame in frames[: count - printed]:
            bodies = {
                names[body.id_num]: list(body.pos) + [body.rot[3], *body.rot[:3]]
                for body in frame.rigid_bodies
                if body.tracking_valid
            }
            captured_us = frame.suffix.stamp_camera_mid_exposure // 10
            line = {"number": frame.prefix.frame_number, "captured_us": captured_us, "bodies": bodies}
            print(json.dumps(line), flush=True)
            printed += 1
        frames.clear()
        time.sleep(0.005)
