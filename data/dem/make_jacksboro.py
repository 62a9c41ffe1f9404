#!/usr/bin/env python3
"""Makes jacksboro.png and jacksboro.toml from the elevation sample in the matplotlib wheel.

    pip download --no-deps matplotlib==3.11.2
    python3 make_jacksboro.py matplotlib-*.whl

The argument is the wheel or the jacksboro_fault_dem.npz inside it. Needs nothing beyond Python itself.

Place: the sample says ymax = 36.446 and ymin = 36.733, so one of them is wrong. It is ymin, made by adding the height to
the northern edge where it should have been taken away: only with row 0 at 36.446 N, rows going south, does the highest
sample (1076 m) stand on Cross Mountain (36.1983 N, 84.2306 W, 1077 m), the flat 305 m of Norris Lake end at Norris Dam,
and the Jacksboro fault run from north-west to south-east. So the first row is the northern one, as in the PNG.

Spacing: the sample gives degrees. On the WGS 84 ellipsoid, at the middle latitude phi,
    dz = dy * pi/180 * a (1 - e2) / (1 - e2 sin2(phi))^1.5        (along the meridian)
    dx = dx * pi/180 * a cos(phi) / (1 - e2 sin2(phi))^0.5        (along the parallel)
"""

import ast
import hashlib
import io
import math
import struct
import sys
import zipfile
import zlib
from pathlib import Path

SAMPLE = "matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
SAMPLE_SHA256 = "d493f50a33e82a4420494c54d1fca1539d177bdc27ab190bc5fe6e92f62fb637"
WGS84_A_M, WGS84_E2 = 6378137.0, 0.00669437999014


def read_npz(path):
    """Name -> (numpy type, shape, bytes) of every array in the sample."""
    sample = Path(path).read_bytes()
    wheel = zipfile.ZipFile(io.BytesIO(sample))
    if SAMPLE in wheel.namelist():
        sample = wheel.read(SAMPLE)
    found = hashlib.sha256(sample).hexdigest()
    assert found == SAMPLE_SHA256, f"another sample: SHA-256 is {found}, expected {SAMPLE_SHA256}"
    archive = zipfile.ZipFile(io.BytesIO(sample))
    arrays = {}
    for member in archive.namelist():
        content = archive.read(member)
        start = 10 + struct.unpack_from("<H", content, 8)[0]
        header = ast.literal_eval(content[10:start].decode())
        assert not header["fortran_order"]
        arrays[member.removesuffix(".npy")] = (header["descr"], header["shape"], content[start:])
    return arrays


def number(arrays, name):
    kind, shape, content = arrays[name]
    assert kind == "<f8" and shape == ()
    return struct.unpack("<d", content)[0]


def spacing_m(dx_deg, dy_deg, latitude_deg):
    phi = math.radians(latitude_deg)
    curvature = 1.0 - WGS84_E2 * math.sin(phi) ** 2
    dx = math.radians(dx_deg) * WGS84_A_M * math.cos(phi) / curvature**0.5
    dz = math.radians(dy_deg) * WGS84_A_M * (1.0 - WGS84_E2) / curvature**1.5
    return dx, dz


def png16(columns, rows, values):
    """A 16-bit greyscale PNG. Each row is filtered with what shrinks it most: nothing, its left or its upper pixel."""

    def chunk(kind, content):
        checksum = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", checksum)

    stride = 2 * columns
    above, filtered = bytes(stride), bytearray()
    for row in range(rows):
        line = struct.pack(f">{columns}H", *values[row * columns : (row + 1) * columns])
        left = bytes(2) + line[:-2]
        candidates = [
            bytes([0]) + line,
            bytes([1]) + bytes((a - b) & 255 for a, b in zip(line, left)),
            bytes([2]) + bytes((a - b) & 255 for a, b in zip(line, above)),
        ]
        filtered += min(candidates, key=lambda bytes_: sum(min(b, 256 - b) for b in bytes_[1:]))
        above = line
    header = struct.pack(">IIBBBBB", columns, rows, 16, 0, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(filtered), 9)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


SIDECAR = """\
# Around the Jacksboro fault, Tennessee: {columns} x {rows} samples, {low} to {high} m. Made by make_jacksboro.py.
spacing_m = [{dx:.4f}, {dz:.4f}]
scale = 1
offset_m = 0
source = "SRTM 3 arc seconds, {south:.4f} to {north:.4f} N, {west:.4f} to {east:.4f} W; NASA and USGS, by way of matplotlib's jacksboro_fault_dem sample"
licence = "public domain (work of the US Government)"
"""


def main():
    arrays = read_npz(sys.argv[1])
    kind, (rows, columns), content = arrays["elevation"]
    assert kind == "<i2"
    heights_m = struct.unpack(f"<{rows * columns}h", content)
    assert min(heights_m) >= 0, "a void, or land below the sea: the values would not fit into 16 bits as they are"

    # The limits are the outer edges of the samples' squares. See above for why "ymin" is not read.
    west, east, north = (number(arrays, name) for name in ("xmin", "xmax", "ymax"))
    dx_deg, dy_deg = number(arrays, "dx"), number(arrays, "dy")
    assert round((east - west) / dx_deg) == columns
    south = north - rows * dy_deg

    dx, dz = spacing_m(dx_deg, dy_deg, 0.5 * (north + south))
    folder = Path(__file__).parent
    (folder / "jacksboro.png").write_bytes(png16(columns, rows, heights_m))
    facts = dict(columns=columns, rows=rows, low=min(heights_m), high=max(heights_m), dx=dx, dz=dz)
    edges = dict(north=north, south=south, west=-west, east=-east)
    (folder / "jacksboro.toml").write_text(SIDECAR.format(**facts, **edges))


if __name__ == "__main__":
    main()
