"""Truncation of results: cvol_keep."""

from __future__ import annotations

from typing import Any

from . import _abi


class Keep:
    """The terms to keep of a result (or in compression by truncation), the largest first.

    Make one by a class method. N is the number of samples; the low box has the k lowest frequencies of each axis,
    stored without positions; s is the number of other terms.
    """

    def __init__(self, value: Any, text: str) -> None:
        self._value, self._text = value, text

    def __repr__(self) -> str:
        return f"Keep.{self._text}"

    @classmethod
    def _by(cls, rule: str, *numbers: float) -> "Keep":
        text = ", ".join(map(str, numbers))
        return cls(_abi.functions["keep_" + rule](*numbers), f"{rule}({text})")

    @classmethod
    def like_inputs(cls) -> "Keep":
        """As coarse as the operands allow (the default of operations)."""
        return cls._by("like_inputs")

    @classmethod
    def all(cls) -> "Keep":
        """All nonzero terms."""
        return cls._by("all")

    @classmethod
    def terms(cls, k: int, s: int) -> "Keep":
        """The k lowest frequencies of each axis, and the s largest others."""
        return cls._by("terms", k, s)

    @classmethod
    def rho(cls, rho: float) -> "Keep":
        """(low box + 2 s) / N at most rho."""
        return cls._by("rho", rho)

    @classmethod
    def ratio(cls, ratio: float) -> "Keep":
        """4 N / resident bytes at least ratio."""
        return cls._by("ratio", ratio)

    @classmethod
    def psnr(cls, decibels: float) -> "Keep":
        """Dropped terms lower the PSNR to no less than these decibels."""
        return cls._by("psnr", decibels)

    @classmethod
    def l2(cls, error: float) -> "Keep":
        """The L2 norm of the dropped terms is at most error."""
        return cls._by("l2", error)

    @classmethod
    def threshold(cls, magnitude: float) -> "Keep":
        """Terms of at least this magnitude."""
        return cls._by("threshold", magnitude)

    @classmethod
    def step(cls, step: float) -> "Keep":
        """Blocks only: terms quantized to multiples of step, like the codec."""
        return cls._by("step", step)

    @classmethod
    def loss(cls, error: float) -> "Keep":
        """Blocks only: like step, with the coarsest step whose loss has an L2 norm of at most error."""
        return cls._by("loss", error)
