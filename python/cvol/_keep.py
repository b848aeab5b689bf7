"""What of a result is kept: cvol_keep."""

from __future__ import annotations

from typing import Any

from . import _abi


class Keep:
    """Which terms of a result (or of a compression by truncation) are kept, the largest first.

    Made by one of the class methods. N is the number of samples; the low box has the k lowest frequencies of
    each axis, whose places need not be stored; s counts the others.
    """

    def __init__(self, value: Any, text: str) -> None:
        self._value, self._text = value, text

    def __repr__(self) -> str:
        return f"Keep.{self._text}"

    @classmethod
    def _by(cls, rule: str, *numbers: float) -> "Keep":
        told = ", ".join(map(str, numbers))
        return cls(_abi.functions["keep_" + rule](*numbers), f"{rule}({told})")

    @classmethod
    def like_inputs(cls) -> "Keep":
        """As coarse as the coarsest operand (the default of operations)."""
        return cls._by("like_inputs")

    @classmethod
    def all(cls) -> "Keep":
        """Every term that is not zero."""
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
        """What is dropped costs no more than these decibels allow."""
        return cls._by("psnr", decibels)

    @classmethod
    def l2(cls, error: float) -> "Keep":
        """The L2 norm of what is dropped is at most error."""
        return cls._by("l2", error)

    @classmethod
    def threshold(cls, magnitude: float) -> "Keep":
        """Terms of at least this magnitude."""
        return cls._by("threshold", magnitude)

    @classmethod
    def step(cls, step: float) -> "Keep":
        """In blocks alone: multiples of step, as the codec keeps them."""
        return cls._by("step", step)
