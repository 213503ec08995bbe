"""Makes the picture of the README: sheet.py OUTPUT."""

import sys

import numpy as np
from conftest import PACKAGE, Server, read
from PIL import Image

server = Server(PACKAGE)
layers = {"image": read("tablet.color.jpg"), "normal": read("tablet.normal.png")}
results = [
    server.call("RelievoEnhance", **layers, scaling=1.0),
    server.call("RelievoRelight", **layers, light="135,30"),
    server.call("RelievoHatch", **layers, enlarge="2"),
    server.call("RelievoShape", normal=layers["normal"]),
]
sheet = Image.new("RGB", (3 * 256, 2 * 256))
for at, batch in enumerate([*layers.values(), *(outputs[0] for outputs in results)]):
    image = Image.fromarray(np.round(batch[0] * 255).astype(np.uint8)).resize((256, 256), Image.Resampling.BOX)
    sheet.paste(image, (at % 3 * 256, at // 3 * 256))
sheet.save(sys.argv[1], quality=88)
