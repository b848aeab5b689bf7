"""A volume in a notebook: the interactive page of `cvol export`, or a picture without it."""

from __future__ import annotations

import base64
import html
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Optional, Union

from ._call import Error
from ._library import candidates

if TYPE_CHECKING:
    from ._volume import Volume


def _command() -> Optional[str]:
    """The command cvol: the file in CVOL, the one next to the library, or the one in PATH."""
    named = os.environ.get("CVOL")
    if named:
        return named
    for library in candidates():
        path = os.path.join(os.path.dirname(library), "cvol")
        if os.sep in library and os.access(path, os.X_OK) and os.path.isfile(path):
            return path
    return shutil.which("cvol")


def _page(volume: "Volume", title: str) -> str:
    """The page. Error: a sentence that says why there is none."""
    command = _command()
    if command is None:
        raise Error("the command cvol is not installed, which makes the interactive page")
    with tempfile.TemporaryDirectory(prefix="cvol-view-") as folder:
        file, page = os.path.join(folder, "volume.cvol"), os.path.join(folder, "page.html")
        volume.save(file)
        try:
            run = subprocess.run(
                [command, "export", "--html", file, "-o", page, "--title", title],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
        except OSError as error:
            raise Error(f"{command}: {error.strerror}") from None
        if run.returncode:
            last = (run.stderr.strip() or f"{command} failed with status {run.returncode}").splitlines()[-1]
            raise Error(last.removeprefix("cvol: "))
        return Path(page).read_text(encoding="utf-8")


def picture_html(volume: "Volume") -> Optional[str]:
    """A picture of a volume and a line of its properties, as HTML; None: a volume of one axis has no picture."""
    png = volume._repr_png_()
    if png is None:
        return None
    sides = " × ".join(f"{s:g}" for s in volume.spacing)
    caption = f"{' × '.join(map(str, volume.shape))} {volume.dtype}, spacing {sides} {volume.geometry.unit}".strip()
    data = base64.b64encode(png).decode()
    return f'<div><img src="data:image/png;base64,{data}" alt="cvol volume"><br>{html.escape(caption)}</div>'


class View:
    """What `Volume.view` returns: a notebook shows it.

    html: the interactive page, complete; None: it could not be made, and `reason` says why. A notebook then shows a
    picture and the reason.
    """

    def __init__(self, volume: "Volume", height: int, title: str) -> None:
        self._height = height
        self.html: Optional[str] = None
        self.reason = ""
        self._picture = ""
        try:
            self.html = _page(volume, title)
        except Error as error:
            self.reason = str(error)
            self._picture = picture_html(volume) or ""

    def _repr_html_(self) -> str:
        if self.html is None:
            return f"{self._picture}<p>No interactive view: {html.escape(self.reason)}</p>"
        style = f"width:100%;height:{self._height}px;border:0"
        return f'<iframe style="{style}" srcdoc="{html.escape(self.html)}"></iframe>'

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the page, which opens in any browser. Error: there is no page."""
        if self.html is None:
            raise Error(f"there is no page to save: {self.reason}")
        Path(path).write_text(self.html, encoding="utf-8")
