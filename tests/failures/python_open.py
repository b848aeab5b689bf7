"""usage: python_open.py PATH     (under faults.so, with CVOL_FAULT_LATE; failures.py runs it)

Opens a .cvol file by the Python package, reads a slice, and prints a checksum of it. Only calls by libcvol fail."""
import ctypes
import sys
import zlib

import cvol

shim = ctypes.CDLL(None)
getattr(shim, "faults_begin", lambda: None)()
try:
    volume = cvol.open(sys.argv[1])
    data = volume[3:9].tobytes()
except (cvol.Error, OSError, MemoryError, ValueError) as error:
    getattr(shim, "faults_end", lambda: None)()
    print("cvol: %s" % error, file=sys.stderr)
    sys.exit(1)
getattr(shim, "faults_end", lambda: None)()
print(zlib.crc32(data))
