"""Small picture files from scratch, for attack.py."""

import math
import struct
import zlib


def attribute(name, kind, value):
    """An attribute of an EXR header."""
    return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value


def exr(channels, width, height):
    """An EXR file of one part, 32-bit floats, uncompressed; channels maps names to functions of x and y."""
    names = sorted(channels)
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", b"".join(n.encode() + struct.pack("<xiB3xii", 2, 0, 1, 1) for n in names) + b"\0")
    header += attribute("compression", "compression", b"\0") + attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + b"\0"
    rows = [[channels[n](x, y) for n in names for x in range(width)] for y in range(height)]
    chunks = [struct.pack("<ii", y, 4 * len(r)) + struct.pack(f"<{len(r)}f", *r) for y, r in enumerate(rows)]
    first = len(header) + 8 * height
    return header + b"".join(struct.pack("<Q", first + y * len(chunks[0])) for y in range(height)) + b"".join(chunks)


def bumps(number=0):
    """The layers of a frame: bumps with slopes of up to a half, and their picture."""

    def normal(x, y):
        x, y = (x + number) / 4, y / 4
        slope = 0.5 * math.sin(x) * math.cos(y), -0.5 * math.cos(x) * math.sin(y)
        length = math.hypot(*slope, 1)
        return slope[0] / length, slope[1] / length, 1 / length

    layers = {f"N.{axis}": lambda x, y, i=i: normal(x, y)[i] for i, axis in enumerate("XYZ")}
    layers.update({name: lambda x, y: 0.8 * normal(x, y)[2] for name in "RGB"})
    layers["Z"] = lambda x, y: 5 + 0.01 * (x + y)
    return layers


def chunk(name, data):
    """A chunk of a PNG."""
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def colored_png(width, height):
    """A PNG that passes for a photo and for a normal map."""
    row = lambda y: bytes([0]) + b"".join(bytes([96 + 64 * x // width, 160 - 64 * y // height, 240]) for x in range(width))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(b"".join(map(row, range(height))), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def hdr(width, height):
    """A Radiance HDR file without run lengths."""
    pixels = bytes([128, 128, 140, 129]) * (width * height)
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + pixels


def tiff(width, height):
    """A TIFF file of floats in red, green and blue."""
    data = struct.pack("<f", 0.5) * (3 * width * height)
    bits = struct.pack("<6H", 32, 32, 32, 3, 3, 3)
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 3, 8), (259, 3, 1, 1), (262, 3, 1, 2), (273, 4, 1, 20),
               (277, 3, 1, 3), (278, 4, 1, height), (279, 4, 1, len(data)), (339, 3, 3, 14)]
    table = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", *e) for e in entries) + bytes(4)
    return b"II*\0" + struct.pack("<I", 20 + len(data)) + bits + data + table
