"""Calls of the library: a context for each call, exceptions, progress, and Ctrl-C.

ctypes lets other Python threads run while the library works. Each call has its own context, so calls of several
threads are independent. During a call of the main thread, Ctrl-C sets a flag, which stops the call at its next
progress report. Calls in the callbacks of a call share its flag.
"""

from __future__ import annotations

import contextlib
import contextvars
import ctypes as c
import os
import re
import signal
import threading
from collections.abc import Callable, Iterator
from typing import Any, Optional

from . import _abi

Progress = Callable[[str, float], Any]


class Error(Exception):
    """A failure of libcvol, with its message. `code` is the number of the error."""

    code = 0


class ArgumentError(Error, ValueError):
    """An argument is invalid."""


class OutOfMemoryError(Error, MemoryError):
    """An allocation failed."""


class FileError(Error, OSError):
    """The operating system refused a read or a write."""


class MissingFileError(FileError, FileNotFoundError):
    """There is no such file."""


class FormatError(Error, ValueError):
    """A file violates its format."""


class CorruptError(FormatError):
    """A .cvol file is damaged: a checksum or an invariant is wrong."""


class UnsupportedError(Error, NotImplementedError):
    """Valid, but not supported by this build of libcvol."""


class LimitError(Error, MemoryError):
    """Larger than the limit of memory allows (see `options`)."""


class DataError(Error, ValueError):
    """Samples that cannot be compressed: NaN or infinite ones."""


class TargetError(Error, ValueError):
    """The ratio, PSNR or error cannot be reached."""


class Cancelled(Error):
    """The progress function returned a true value."""


_CLASSES = {
    _abi.ERRORS["ERROR_ARGUMENT"]: ArgumentError,
    _abi.ERRORS["ERROR_MEMORY"]: OutOfMemoryError,
    _abi.ERRORS["ERROR_IO"]: FileError,
    _abi.ERRORS["ERROR_FORMAT"]: FormatError,
    _abi.ERRORS["ERROR_CORRUPT"]: CorruptError,
    _abi.ERRORS["ERROR_UNSUPPORTED"]: UnsupportedError,
    _abi.ERRORS["ERROR_LIMIT"]: LimitError,
    _abi.ERRORS["ERROR_DATA"]: DataError,
    _abi.ERRORS["ERROR_TARGET"]: TargetError,
    _abi.ERRORS["ERROR_CANCELLED"]: Cancelled,
}


# Messages advise options of the command; here arguments have other names.
_ARGUMENTS = {
    "--dims NXxNYxNZ": "shape=(nz, ny, nx)",
    "--type": "dtype=",
    "--fill VALUE": "fill=VALUE",
    "--spacing SX,SY,SZ": "spacing=(sz, sy, sx)",
    "--channel": "channel=",
    "--time": "time=",
    "--series": "series=",
}


def _in_python(message: str) -> str:
    for option, argument in _ARGUMENTS.items():  # whole words: not parts of a path
        value = r"(?: (?=u?int\d|float\d))?" if argument.endswith("=") else ""
        message = re.sub(rf"(?<!\S){re.escape(option)}(?=[\s;:,]|$){value}", argument, message)
    return message


class _Settings:
    def __init__(
        self, threads: int = 0, progress: Optional[Progress] = None, limit: int = 0, external: bool = True
    ) -> None:
        self.threads, self.progress, self.limit, self.external = threads, progress, limit, external


_settings: contextvars.ContextVar[_Settings] = contextvars.ContextVar("cvol_settings", default=_Settings())


@contextlib.contextmanager
def options(
    *,
    threads: Optional[int] = None,
    progress: Optional[Progress] = None,
    memory_limit: Optional[int] = None,
    external: Optional[bool] = None,
) -> Iterator[None]:
    """Settings for all calls in a ``with`` block (of this thread).

    threads: worker threads of the library; 0: all cores. Results have the same bits for any number.
    progress: long calls call ``progress(what, fraction)`` with a description of the step and the finished share of
        it (0 to 1). A true result stops the call, which raises `Cancelled`; an exception stops it and leaves it.
    memory_limit: the largest volume, in bytes, that cvol allocates because a file says so (default 64 GiB).
    external: False: open no other files that a header of NRRD or MetaImage names; such headers raise an error.
    """
    now = _settings.get()
    token = _settings.set(
        _Settings(
            now.threads if threads is None else threads,
            now.progress if progress is None else progress,
            now.limit if memory_limit is None else memory_limit,
            now.external if external is None else external,
        )
    )
    try:
        yield
    finally:
        _settings.reset(token)


class _Interrupt:
    """Handles Ctrl-C during calls of the main thread: an exception cannot leave a callback, so it sets a flag, and the
    innermost call raises the exception when the library has returned."""

    def __init__(self) -> None:
        self.came = False

    def note(self, *_: Any) -> None:
        self.came = True

    def take(self) -> bool:
        came, self.came = self.came, False
        return came


_interrupt = _Interrupt()


class Call:
    """One call's context. ``with Call() as call: call("array_add", ...)`` raises errors."""

    def __init__(self, progress: Optional[Progress] = None) -> None:
        settings = _settings.get()
        self._user = progress or settings.progress
        self._failure: Optional[BaseException] = None
        self._handler: Any = None  # the one to restore
        self._watches = False
        self.context = _abi.functions["context_create"]()
        if not self.context:
            raise OutOfMemoryError("not enough memory for a context")
        self._callback = _abi.ProgressFunction(self._tell)  # the library does not keep it alive
        _abi.functions["context_set_progress"](self.context, self._callback, None)
        if settings.threads:
            _abi.functions["context_set_threads"](self.context, settings.threads)
        if settings.limit:
            _abi.functions["context_set_limit_bytes"](self.context, settings.limit)
        if not settings.external:
            _abi.functions["context_set_external"](self.context, 0)

    def _tell(self, _: Any, what: bytes, fraction: float) -> int:
        if self._watches and _interrupt.came:
            return 1
        if not self._user:
            return 0
        now = _settings.get()  # calls by the function itself do not report to it
        token = _settings.set(_Settings(now.threads, None, now.limit, now.external))
        try:
            return int(bool(self._user(what.decode(errors="replace"), fraction)))
        except BaseException as error:  # pylint: disable=broad-except
            self._failure = error
            return 1
        finally:
            _settings.reset(token)

    def __enter__(self) -> "Call":
        if threading.current_thread() is threading.main_thread():
            handler = signal.getsignal(signal.SIGINT)
            if handler is signal.default_int_handler:
                self._handler = signal.signal(signal.SIGINT, _interrupt.note)
            self._watches = self._handler is not None or handler == _interrupt.note
        return self

    def __exit__(self, *_: Any) -> None:
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
        _abi.functions["context_free"](self.context)
        self.context = None
        if self._watches and _interrupt.take():
            raise KeyboardInterrupt

    def __call__(self, name: str, *arguments: Any, path: Optional[str] = None) -> None:
        """Calls cvol_NAME with this context as the first argument. path: the file of the message."""
        try:
            code = _abi.functions[name](self.context, *arguments)
        except c.ArgumentError as error:  # it names the place of the argument, behind the context
            place = re.match(r"argument (\d+)", str(error))
            value = arguments[int(place[1]) - 2] if place else arguments
            raise TypeError(f"{value!r} is no argument of cvol_{name}: it must be a number") from None
        if code == _abi.OK:
            return
        if self._failure is not None:
            raise self._failure
        text = _abi.functions["context_message"](self.context).decode(errors="replace")
        kind = _CLASSES.get(code, Error)
        if kind is FileError and path is not None and not os.path.exists(path):
            kind = MissingFileError
        error = kind(_in_python(text))
        error.code = code
        raise error


class Handle:
    """An object of the library, freed when it is closed and no call uses it."""

    def __init__(self, pointer: int, free: str, what: str) -> None:
        self._pointer, self._free, self._what = pointer, _abi.functions[free], what
        self._lock = threading.Lock()
        self._uses = 0
        self._closed = False

    def acquire(self) -> int:
        with self._lock:
            if self._closed:
                raise ValueError(f"{self._what} is closed")
            self._uses += 1
        return self._pointer

    def release(self) -> None:
        with self._lock:
            self._uses -= 1
            last = self._closed and not self._uses
        if last:
            self._free(self._pointer)

    def __enter__(self) -> int:
        return self.acquire()

    def __exit__(self, *_: Any) -> None:
        self.release()

    @contextlib.contextmanager
    def _released(self, pointer: int) -> Iterator[int]:
        try:
            yield pointer
        finally:
            self.release()

    def hold(self) -> contextlib.AbstractContextManager[int]:
        """Acquires the object now, for a ``with`` block that begins later: nobody can free it in between."""
        return self._released(self.acquire())

    @property
    def closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        with self._lock:
            if self._closed:
                return
            self._closed = True
            last = not self._uses
        if last:
            self._free(self._pointer)

    def __del__(self) -> None:
        # A handle in use has references.
        if hasattr(self, "_closed"):
            self.close()


def path_bytes(path: Any) -> bytes:
    """A path as bytes, for the library."""
    return os.fsencode(os.fspath(path))


def out_pointer() -> c.c_void_p:
    return c.c_void_p()
