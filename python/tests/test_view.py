"""Volumes in notebooks: the page of cvol export in a frame, or a picture. A script stands in for the command."""

import base64
import html
import os
import re

import cvol
import numpy as np
import pytest

PAGE = '<!doctype html><title>"a" & b</title><script>1 < 2</script>'


def command(folder, monkeypatch, lines):
    path = folder / "command"
    path.write_text("#!/bin/sh\n" + lines)
    path.chmod(0o755)
    monkeypatch.setenv("CVOL", str(path))


def test_page(volume, tmp_path, monkeypatch):
    (tmp_path / "page").write_text(PAGE)
    copy = f'echo "$@" >{tmp_path}/words; cp "$3" {tmp_path}/got.cvol; cp {tmp_path}/page "$5"\n'
    command(tmp_path, monkeypatch, copy)
    view = volume.view(height=333, title="my scan")
    assert re.fullmatch(r"export --html \S+\.cvol -o \S+\.html --title my scan\n", (tmp_path / "words").read_text())
    assert np.array_equal(cvol.open(tmp_path / "got.cvol"), volume)
    text = view._repr_html_()
    found = re.fullmatch(r'<iframe style="width:100%;height:333px;border:0" srcdoc="([^"<]*)"></iframe>', text)
    assert html.unescape(found[1]) == PAGE == view.html
    view.save(tmp_path / "saved.html")
    assert (tmp_path / "saved.html").read_text() == PAGE


def png(text):
    return base64.b64decode(re.search(r"data:image/png;base64,([^\"]+)", text)[1])


def test_without_a_page(volume, tmp_path, monkeypatch):
    command(tmp_path, monkeypatch, "echo 'cvol: the page <is> not there: run make web' >&2; exit 1\n")
    view = volume.view()
    text = view._repr_html_()
    assert png(text) == volume._repr_png_() and view.html is None
    assert text.endswith("<p>No interactive view: the page &lt;is&gt; not there: run make web</p>")
    with pytest.raises(cvol.Error, match="there is no page to save: the page <is> not there"):
        view.save(tmp_path / "no.html")
    monkeypatch.setenv("CVOL", str(tmp_path / "missing"))
    assert "missing: No such file" in volume.view().reason
    monkeypatch.delenv("CVOL")
    monkeypatch.setattr("cvol._view.candidates", list)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "the command cvol is not installed" in volume.view()._repr_html_()


def test_the_command_of_the_build(volume, monkeypatch):
    """Its page if the build has one (make web), else its reason."""
    monkeypatch.delenv("CVOL", raising=False)
    from cvol._view import _command

    if _command() is None or not os.path.exists(_command()):
        pytest.skip("the command cvol is not built: its page is not tested")
    view = volume.view()
    if view.html is None:
        assert "the page is not there" in view.reason
    else:
        assert view.html.lstrip().lower().startswith("<!doctype html")


def test_representations(volume):
    text = volume._repr_html_()
    assert png(text) == volume._repr_png_() and "70 × 24 × 80 int16, spacing 2 × 1 × 0.5" in text
    line = cvol.compress(np.arange(50, dtype="f4"), keep=cvol.Keep.all())
    assert line._repr_html_() is None
    with pytest.raises(ValueError, match="has 1 axes, must have 3"):
        line.view()
    line.close()
    assert line._repr_html_() is None
    with pytest.raises(ValueError, match="closed"):
        line.view()
