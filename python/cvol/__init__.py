"""cvol: compressed volumes that you slice, render and compute with, without decompressing them.

>>> import cvol
>>> v = cvol.compress(array, ratio=30, spacing=(1.5, 0.9, 0.9))   # array[z, y, x]
>>> v.save("scan.cvol")
>>> v = cvol.open("scan.cvol")
>>> v[10:20, :, 5]                     # decodes only these samples
>>> v.render(azimuth=30, elevation=20)  # uint8, (h, w, 3)
>>> w = v.convolve("gaussian:2") - 0.5 * v
>>> w.stats().mean, w.error_bound
"""

from ._call import (
    ArgumentError,
    Cancelled,
    CorruptError,
    DataError,
    Error,
    FileError,
    FormatError,
    LimitError,
    MissingFileError,
    OutOfMemoryError,
    TargetError,
    UnsupportedError,
    options,
)
from ._algebra import Comparison, Region, RegionStatistics, Statistics
from ._colours import Colours, open_colours
from ._compress import compress, compress_series, is_labels, transcode
from ._dense import DenseVolume
from ._frames import Series
from ._files import formats, open, read, write
from ._geometry import Geometry
from ._interpolate import interpolate, interpolate_chirp, interpolate_pencil
from ._keep import Keep
from ._levels import Level
from ._library import VERSION as __version__
from ._picture import encode_png, save_png
from ._render import Renderer
from ._series import Contents, contents, save_series
from ._transfer import names as transfer_names
from ._volume import Info, Volume

__all__ = [
    "ArgumentError", "Cancelled", "Colours", "Comparison", "Contents", "CorruptError", "DataError", "DenseVolume",
    "Error", "FileError", "FormatError", "Geometry", "Info", "Keep", "Level", "LimitError", "MissingFileError",
    "OutOfMemoryError", "Region", "RegionStatistics", "Renderer", "Series", "Statistics", "TargetError",
    "UnsupportedError", "Volume", "__version__", "compress", "compress_series", "contents", "encode_png", "formats",
    "interpolate", "interpolate_chirp", "interpolate_pencil", "is_labels", "open", "open_colours", "options",
    "read", "save_png", "save_series", "transcode", "transfer_names", "write",
]  # fmt: skip
