"""Operations on compressed volumes, never on their samples: + - *, filters, statistics.

Every result has a certified bound (`Volume.error_bound`). Its samples are float32; `astype` changes that.
Operands must have the same shape, spacing, transform and block, or ArgumentError names the difference.
"""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from . import _abi
from ._call import Call, Handle, out_pointer
from ._geometry import address
from ._keep import Keep

if TYPE_CHECKING:
    from ._volume import Volume

_PLANS = ("auto", "direct", "grid", "full", "sparse", "blocks", "low")


@dataclass(frozen=True)
class Statistics:
    """Statistics of the samples of a volume; each *_error bounds the difference from the exact value."""

    sum: float
    mean: float
    variance: float
    standard_deviation: float
    l2_norm: float
    sum_error: float
    mean_error: float
    standard_deviation_error: float
    l2_norm_error: float


@dataclass(frozen=True)
class Comparison:
    """sum a b; that / (\\|a\\| \\|b\\|); \\|a - b\\|; and bounds of the differences from the exact values."""

    inner_product: float
    cosine_similarity: float
    distance: float
    inner_product_error: float
    distance_error: float


@dataclass(frozen=True)
class Region:
    """What is known about the original samples of a box: how many have values in a range, and their sum and mean.

    Of the original samples, at least `inside_least` and at most `inside_most` are in the range; each *_error bounds
    the difference from the exact value. Samples without a value do not count.
    """

    samples: int
    inside: int
    inside_least: int
    inside_most: int
    sum: float
    mean: float
    sum_error: float
    mean_error: float


@dataclass(frozen=True)
class RegionStatistics:
    """Statistics of the decoded samples of a box or an ellipsoid.

    Each *_error bounds the difference from the figure of the original samples. Samples without a value do not count.
    """

    samples: int
    mean: float
    standard_deviation: float
    least: float
    largest: float
    mean_error: float
    standard_deviation_error: float
    least_error: float
    largest_error: float


def _record(kind: Any, struct: Any) -> Any:
    return kind(**{name: getattr(struct, name) for name, _ in struct._fields_})


def _keep(keep: Optional[Keep]) -> Any:
    if keep is None:
        return None
    if not isinstance(keep, Keep):
        raise TypeError(f"keep is {keep!r}, must be a cvol.Keep or None")
    return c.byref(keep._value)


class Algebra:
    """The operations of `Volume`."""

    _store: Any
    if TYPE_CHECKING:  # what Volume has

        @property
        def shape(self) -> tuple[int, ...]: ...

        @property
        def ndim(self) -> int: ...


    def _make(self, function: str, *arguments: Any, others: Sequence["Volume"] = ()) -> "Volume":
        """Calls function(context, out, *arguments), in which operands are volumes."""
        out = out_pointer()
        handles = {id(v): v._store.whole() for v in (self, *others)}
        held = list(handles.values())
        pointers = {key: handle.acquire() for key, handle in handles.items()}
        try:
            with Call() as call:
                call(function, c.byref(out), *[pointers.get(id(a), a) for a in arguments])
                return self._take(out)  # type: ignore[attr-defined,no-any-return]
        finally:
            for handle in held:
                handle.release()

    def _other(self, other: Any) -> "Volume":
        if not isinstance(other, Algebra):
            raise TypeError(f"the other operand is a {type(other).__name__}, must be a cvol.Volume: compress it")
        return other  # type: ignore[return-value]

    # ---- sums -----------------------------------------------------------------------------------------

    def add(self, other: "Volume", alpha: float = 1, beta: float = 1, keep: Optional[Keep] = None) -> "Volume":
        """alpha self + beta other. Bound: |alpha| e_self + |beta| e_other + dropped. Cost: O(terms)."""
        other = self._other(other)
        return self._make("array_add", alpha, self, beta, other, _keep(keep), others=[other])

    def scale(self, factor: float, offset: float = 0) -> "Volume":
        """factor self + offset, sample by sample; keeps the terms. Cost: O(terms)."""
        return self._make("array_scale", factor, self, offset)

    def _binary(self, other: Any, alpha: float, beta: float) -> Any:
        """alpha self + beta other, other a volume or a number."""
        if isinstance(other, Algebra):
            return self.add(other, alpha, beta)  # type: ignore[arg-type]
        if isinstance(other, (Real, np.number)):
            return self.scale(alpha, beta * float(other))
        if isinstance(other, np.ndarray):
            raise TypeError("one operand is a NumPy array: compress it, or use to_numpy() of the other")
        return NotImplemented

    def __add__(self, other: Any) -> "Volume":
        return self._binary(other, 1, 1)  # type: ignore[no-any-return]

    __radd__ = __add__

    def __sub__(self, other: Any) -> "Volume":
        return self._binary(other, 1, -1)  # type: ignore[no-any-return]

    def __rsub__(self, other: Any) -> "Volume":
        return self._binary(other, -1, 1)  # type: ignore[no-any-return]

    def __neg__(self) -> "Volume":
        return self.scale(-1)

    def __pos__(self) -> "Volume":
        return self  # type: ignore[return-value]

    def __truediv__(self, other: Any) -> "Volume":
        if isinstance(other, (Real, np.number)):
            return self.scale(1 / float(other))
        raise TypeError("a volume can be divided by a number only: use to_numpy() for other quotients")

    def __rtruediv__(self, other: Any) -> "Volume":
        raise TypeError("a volume cannot divide on coefficients: use to_numpy() for quotients")

    # ---- products -------------------------------------------------------------------------------------

    def __mul__(self, other: Any) -> "Volume":
        if isinstance(other, Algebra):
            return self.multiply(other)  # type: ignore[arg-type]
        if isinstance(other, (Real, np.number)):
            return self.scale(float(other))
        return self._binary(other, 1, 1)  # type: ignore[no-any-return]

    __rmul__ = __mul__

    def multiply(self, other: "Volume", keep: Optional[Keep] = None, plan: str = "auto") -> "Volume":
        """self other, sample by sample. plan: "auto", or "direct", "grid", "full", "sparse", "low" (whole arrays),
        "blocks". Bound: min(max|a| e_b + max|b~| e_a, max|a~| e_b + max|b| e_a) + dropped."""
        other = self._other(other)
        if plan not in _PLANS:
            raise ValueError(f"plan is {plan!r}, must be one of {', '.join(_PLANS)}")
        return self._make(
            "array_multiply", self, other, _keep(keep), _PLANS.index(plan), None, others=[other])  # fmt: skip

    def convolve(self, kernel: Union[str, Sequence[float], "Volume"], keep: Optional[Keep] = None) -> "Volume":
        """(h * a)[i] = sum_j h[j] a[i - j].

        kernel: "gaussian:SIGMA", "box:WIDTH", "laplacian", "unsharp:SIGMA[,AMOUNT]", "derivative:x" (sigma and
        width in samples); or an odd number of taps, symmetric or antisymmetric, for every axis; or a volume,
        circular, of whole arrays under "dft" or "dht". Bound: max|H| e + dropped.
        """
        if isinstance(kernel, Algebra):
            return self._make(
                "array_convolve", self, kernel, _keep(keep), others=[kernel])  # fmt: skip
        built = _abi.Kernel()
        with Call() as call:
            if isinstance(kernel, str):
                call("kernel_parse", c.byref(built), self.ndim, kernel.encode())
            else:
                taps = np.ascontiguousarray(kernel, float)
                if taps.ndim != 1 or len(taps) % 2 == 0:
                    raise ValueError(f"the kernel has shape {taps.shape}, must have one axis and an odd length")
                call("kernel_taps", c.byref(built), self.ndim, address(taps), len(taps) // 2)
        return self._make("array_convolve_kernel", self, c.byref(built), _keep(keep))

    def gradient(self, keep: Optional[Keep] = None) -> "Volume":
        """Length of the gradient by central differences, per unit of spacing."""
        return self._make("array_gradient", self, _keep(keep))

    def shift(self, offset: Sequence[float]) -> "Volume":
        """The volume shifted by an offset (in samples, in the order of `shape`). Whole arrays, "dft" and "dht"."""
        offset = [float(v) for v in offset]
        if len(offset) != self.ndim:
            raise ValueError(f"offset has {len(offset)} numbers, must have {self.ndim}")
        return self._make("array_shift", self, _abi.Double3(*offset[::-1], *[0.0] * (3 - self.ndim)))

    def resample(self, factor: int, keep: Optional[Keep] = None) -> "Volume":
        """Twice (factor 2) or half (-2) as many samples along each axis. A sample that is made of a missing one is
        missing."""
        if factor not in (2, -2):
            raise ValueError(f"factor is {factor!r}, must be 2 or -2")
        return self._make("array_resample", self, int(factor), _keep(keep))

    def truncate(self, keep: Keep) -> "Volume":
        """The volume with fewer terms."""
        return self._make("array_truncate", self, _keep(keep))

    # ---- statistics -----------------------------------------------------------------------------------

    def stats(self) -> Statistics:
        """Sum, mean, variance and norm, with bounds of their errors. Samples without a value do not count."""
        out = _abi.Statistics()
        with self._store.whole() as array, Call() as call:
            call("array_compute_statistics", c.byref(out), array)
        return _record(Statistics, out)  # type: ignore[no-any-return]

    def _corners(
        self, begin: Optional[Sequence[int]], end: Optional[Sequence[int]]
    ) -> tuple[tuple[int, ...], tuple[int, ...]]:
        dims: tuple[int, ...] = self.shape  # type: ignore[attr-defined]
        corners = [tuple(begin) if begin is not None else (0,) * len(dims), tuple(end) if end is not None else dims]
        for name, corner in zip(("begin", "end"), corners):
            if len(corner) != len(dims):
                raise ValueError(f"{name} has {len(corner)} numbers, must have {len(dims)}")
            if min(corner) < 0:
                raise ValueError(f"{name} is {corner}, must not be negative")
        return corners[0], corners[1]

    def region(
        self,
        least: float = -math.inf,
        largest: float = math.inf,
        begin: Optional[Sequence[int]] = None,
        end: Optional[Sequence[int]] = None,
    ) -> Region:
        """Counts the samples within least .. largest (both included) of the box begin .. end - 1, with proven bounds.

        Values are those of the array; begin and end are in the order of `shape`, by default the whole. The volume in
        the range is the count times the product of `spacing`. Cost: decodes the box, piece by piece. Raises
        ArgumentError for a box outside of the array, and if least is above largest.
        """
        first, last = self._corners(begin, end)
        pad = 3 - len(first)
        out = _abi.Region()
        with self._store.whole() as array, Call() as call:
            call("array_compute_region", c.byref(out), array, _abi.Size3(*first[::-1], *[0] * pad),
                 _abi.Size3(*last[::-1], *[1] * pad), least, largest)
        return _record(Region, out)  # type: ignore[no-any-return]

    def region_statistics(
        self, begin: Optional[Sequence[int]] = None, end: Optional[Sequence[int]] = None, ellipsoid: bool = False
    ) -> RegionStatistics:
        """Mean, standard deviation, least and largest sample of the box begin .. end - 1, with proven bounds.

        `ellipsoid`: only of the samples in the ellipsoid that touches the faces of the box. Arguments as in `region`.
        Cost: decodes the box, piece by piece. Raises ArgumentError for a box outside of the array.
        """
        first, last = self._corners(begin, end)
        pad = 3 - len(first)
        out = _abi.RegionStatistics()
        with self._store.whole() as array, Call() as call:
            call("array_compute_region_statistics", c.byref(out), array, _abi.Size3(*first[::-1], *[0] * pad),
                 _abi.Size3(*last[::-1], *[1] * pad), int(ellipsoid))
        return _record(RegionStatistics, out)  # type: ignore[no-any-return]

    def norm(self) -> float:
        """sqrt(sum a^2)."""
        return self.stats().l2_norm

    def compare(self, other: "Volume") -> Comparison:
        """Inner product, cosine similarity and distance of two volumes."""
        out = _abi.Comparison()
        with self._store.whole() as a, self._other(other)._store.whole() as b, Call() as call:
            call("array_compare", c.byref(out), a, b)
        return _record(Comparison, out)  # type: ignore[no-any-return]

    def dot(self, other: "Volume") -> float:
        """sum a b."""
        out = c.c_double()
        with self._store.whole() as a, self._other(other)._store.whole() as b, Call() as call:
            call("array_compute_inner_product", c.byref(out), a, b)
        return out.value

    def rms_error_bound(self) -> float:
        """`error_bound` as a root mean square over the samples."""
        return self.error_bound / math.sqrt(self.size)  # type: ignore[attr-defined,no-any-return]
