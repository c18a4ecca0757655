"""Prints frames as libmotioncapture reads them: KIND COUNT KEY=VALUE..."""

import json
import sys

import motioncapture

kind, count = sys.argv[1], int(sys.argv[2])
source = motioncapture.connect(kind, dict(argument.split("=", 1) for argument in sys.argv[3:]))
printed = 0
while printed < count:
    source.waitForNextFrame()
    bodies = {
        name: [float(x) for x in body.position]
        + [body.rotation.w, body.rotation.x, body.rotation.y, body.rotation.z]
        for name, body in source.rigidBodies.items()
    }
    # Before the first frame, and between frames with VRPN, there are no bodies.
    if bodies:
        print(json.dumps({"bodies": bodies}), flush=True)
        printed += 1
