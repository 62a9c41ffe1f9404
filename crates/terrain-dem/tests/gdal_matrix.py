"""Writes one grid of 257 x 257 samples with GDAL in as many variants as our reader takes.

    python3 gdal_matrix.py FOLDER

Each line on stdout names a file, what it holds (NAME.f64: little-endian float64, NaN at voids) and its variant. Exit code
77: rasterio is not there (`pip install rasterio`). No part of the product: GDAL only checks that we agree with it.
"""

import sys
import warnings

try:
    import numpy as np
    import rasterio
    import rasterio.shutil
    from rasterio.crs import CRS
    from rasterio.transform import Affine
except ImportError as missing:
    print(missing)
    sys.exit(77)

SIDE = 257
TYPES = ["uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"]
UTM = Affine(30.0, 0.0, 400000.0, 0.0, -30.0, 3800000.0)


def grid(kind, nodata=None):
    """Hills with noise in the whole range of the type, so that every byte matters."""
    rows, columns = np.mgrid[0:SIDE, 0:SIDE]
    hills = np.sin(columns / 17.0) * np.cos(rows / 23.0) * 0.5 + 0.5
    noise = np.random.default_rng(7).random((SIDE, SIDE)) * 0.1
    low, high = {
        "uint8": (0, 250), "int16": (-9000, 30000), "uint16": (0, 65000), "int32": (-8000000, 8000000),
        "uint32": (0, 16000000), "float32": (-400.0, 4000.0), "float64": (-400.0, 4000.0),
    }[kind]
    values = (low + (hills * 0.9 + noise) * (high - low)).astype(kind)
    if nodata is not None:
        values[100:120, 30:60] = nodata
        values[0, 0] = values[SIDE - 1, SIDE - 1] = nodata
    return values


class Matrix:
    def __init__(self, folder):
        self.folder, self.count = folder, 0

    def write(self, values, expected, driver="GTiff", ending="tif", transform=UTM, crs="EPSG:32611", nodata=None,
              around=None, **options):
        name = f"v{self.count:03}"
        self.count += 1
        bands = values if values.ndim == 3 else values[None]
        profile = dict(driver=driver, width=SIDE, height=SIDE, count=len(bands), dtype=bands.dtype, nodata=nodata,
                       transform=transform, crs=crs and CRS.from_string(crs), **options)
        path = f"{self.folder}/{name}.{ending}"
        with rasterio.open(path, "w", **profile) as file:
            file.write(bands)
            if around:
                around(file)
        expected.astype("<f8").tofile(f"{self.folder}/{name}.f64")
        print(f"{name}.{ending}\t{name}.f64\t{driver} {bands.dtype} nodata={nodata} {options}", flush=True)


def tiff(matrix):
    for kind in TYPES:
        values = grid(kind)
        predictors = [1, 2, 3] if kind.startswith("float") else [1, 2]
        for tiled in [dict(), dict(tiled=True, blockxsize=64, blockysize=48)]:
            for compress in ["none", "lzw", "deflate", "packbits", "zstd"]:
                for predictor in predictors if compress in ["lzw", "deflate", "zstd"] else [1]:
                    matrix.write(values, values, compress=compress, predictor=predictor, **tiled)
        for extra in [dict(BIGTIFF="YES"), dict(blockysize=1), dict(blockysize=257), dict(tiled=True, blockxsize=512, blockysize=512)]:
            matrix.write(values, values, compress="lzw", **extra)
        for predictor in predictors:
            matrix.write(values, values, ENDIANNESS="BIG", compress="deflate", predictor=predictor)
        matrix.write(values, values, ENDIANNESS="BIG", BIGTIFF="YES")
        for interleave in ["pixel", "band"]:
            bands = np.stack([values, values[::-1], values.T])
            for predictor in predictors:
                matrix.write(bands, values, interleave=interleave, compress="lzw", predictor=predictor, photometric="MINISBLACK")
        matrix.write(values, values[::-1], transform=Affine(30.0, 0.0, 0.0, 0.0, 30.0, 0.0))


def voids(matrix):
    for kind, nodata in [("int16", -32768), ("int16", -9999), ("uint16", 0), ("int32", -2147483648),
                         ("float32", -9999.9), ("float32", float("nan")), ("float32", -3.4028234663852886e38), ("float64", -1.7e308)]:
        values = grid(kind, nodata)
        # What the type holds of it, as the file does.
        held = np.asarray(nodata).astype(kind)
        expected = np.where((values == held) | ~np.isfinite(values.astype(float)), np.nan, values.astype(float))
        matrix.write(values, expected, nodata=nodata, compress="deflate")
    values = grid("int16")
    values[64:192, 64:192] = -9999
    matrix.write(values, np.where(values == -9999, np.nan, values.astype(float)), nodata=-9999, SPARSE_OK="TRUE",
                 tiled=True, blockxsize=64, blockysize=64, compress="deflate")
    values = grid("int16")

    def scaled(file):
        file.scales, file.offsets = (0.1,), (-10.0,)
    matrix.write(values, (values * 0.1 + -10.0), around=scaled)

    def feet(file):
        file.units = ("ft",)
    matrix.write(values, values * 0.3048, around=feet)


def others(matrix):
    for kind in ["int16", "uint16"]:
        matrix.write(grid(kind), grid(kind), driver="COG", compress="deflate", blocksize=128)
        matrix.write(grid(kind), grid(kind), driver="EHdr", ending="bil")
    matrix.write(grid("float32"), grid("float32"), driver="COG", compress="lzw", predictor="YES", blocksize=128)
    matrix.write(grid("float32"), grid("float32"), driver="EHdr", ending="flt")
    matrix.write(grid("uint16"), grid("uint16"), driver="PNG", ending="png", transform=None, crs=None)
    matrix.write(grid("uint16"), grid("uint16"), driver="PNM", ending="pgm", transform=None, crs=None)
    matrix.write(grid("int16"), grid("int16"), driver="AAIGrid", ending="asc")
    # AAIGrid copies; its digits are those of a float32.
    matrix.write(grid("float32"), grid("float32"), driver="AAIGrid", ending="asc", SIGNIFICANT_DIGITS=9)
    matrix.write(grid("int16", -9999), np.where(grid("int16", -9999) == -9999, np.nan, grid("int16").astype(float)),
                 driver="AAIGrid", ending="asc", nodata=-9999, FORCE_CELLSIZE="FALSE", transform=Affine(30, 0, 0, 0, -40, 0))


def dted(matrix):
    """One degree, 121 x 121 samples on its rim, all that level 0 allows."""
    values = grid("int16")[:121, :121]
    values[5:9, 5:9] = -32767
    plain, tile = f"{matrix.folder}/plain.tif", f"{matrix.folder}/tile.dt0"
    step = 1 / 120
    with rasterio.open(plain, "w", driver="GTiff", width=121, height=121, count=1, dtype="int16", nodata=-32767,
                       crs="EPSG:4326", transform=Affine(step, 0, 7 - step / 2, 0, -step, 46 + step / 2)) as file:
        file.write(values, 1)
    rasterio.shutil.copy(plain, tile, driver="DTED")
    np.where(values == -32767, np.nan, values.astype(float)).astype("<f8").tofile(f"{matrix.folder}/tile.f64")
    print("tile.dt0\ttile.f64\tDTED", flush=True)


def overviews(matrix):
    """The finest of the smaller versions in a COG; the Rust side asks for it by the word in the line."""
    plain, cog = f"{matrix.folder}/cog_plain.tif", f"{matrix.folder}/cog.tif"
    values = grid("int16")
    with rasterio.open(plain, "w", driver="GTiff", width=SIDE, height=SIDE, count=1, dtype="int16", crs="EPSG:32611",
                       transform=UTM) as file:
        file.write(values, 1)
    rasterio.shutil.copy(plain, cog, driver="COG", blocksize=128, overview_count=2)
    with rasterio.open(cog, overview_level=0) as file:
        file.read(1).astype("<f8").tofile(f"{matrix.folder}/cog.f64")
    print("cog.tif\tcog.f64\tCOG overview=1", flush=True)


def usgs(matrix):
    """In degrees: in UTM, GDAL reads its own file back with a row too many."""
    values = grid("int16")[:121, :100]
    values[5:9, 5:9] = -32767
    plain, tile = f"{matrix.folder}/usgs_plain.tif", f"{matrix.folder}/usgs.dem"
    step = 1 / 1200
    with rasterio.open(plain, "w", driver="GTiff", width=100, height=121, count=1, dtype="int16", nodata=-32767,
                       crs="EPSG:4269", transform=Affine(step, 0, -122 - step / 2, 0, -step, 45 + step / 2)) as file:
        file.write(values, 1)
    rasterio.shutil.copy(plain, tile, driver="USGSDEM", ZRESOLUTION="1.0")
    np.where(values == -32767, np.nan, values.astype(float)).astype("<f8").tofile(f"{matrix.folder}/usgs.f64")
    print("usgs.dem\tusgs.f64\tUSGSDEM", flush=True)


def main():
    # PNG and PGM have no place to say their spacing.
    warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
    matrix = Matrix(sys.argv[1])
    tiff(matrix)
    voids(matrix)
    others(matrix)
    dted(matrix)
    overviews(matrix)
    usgs(matrix)


main()
