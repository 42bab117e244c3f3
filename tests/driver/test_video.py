"""`scripts/video`: frames and films of a run."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import browser  # noqa: E402


def film(folder, *words):
    """Run the script."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts/video.py", "top.h5", *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_export_calls_it(run, scene, tmp_path):
    """`contensou export --video` hands its options on, and refuses those of other formats."""
    assert run("run", scene.name, "-q").status == 0
    done = run("export", "top.h5", "--video", "--size", "321x200", "-o", "frames")
    assert (done.status, done.out) == (2, "")
    assert done.err == "error: --size 321x200: expected even numbers of pixels, as 1280x720\n"
    assert "--frames is not for video" in run("export", "top.h5", "--video", "--frames", "5").err
    assert "--rate is not for gltf" in run("export", "top.h5", "--to", "gltf", "--rate", "5").err
    assert "two formats" in run("export", "top.h5", "--video", "--to", "vtk").err
    (tmp_path / "film.mp4").write_text("kept")
    assert "exists; --force replaces it" in run("export", "top.h5", "-o", "film.mp4").err
    assert (tmp_path / "film.mp4").read_text() == "kept"


@pytest.mark.skipif(browser.PROGRAM is None, reason="there is no Chromium")
def test_frames_and_film(run, scene, tmp_path):
    """As many frames as asked for, which differ; a film of them where there is ffmpeg."""
    assert run("run", scene.name, "-q").status == 0
    end = run("export", "top.h5", "--csv", "-c", "time").out.split()[-1]
    words = ["--rate", "2", "--speed", end, "--size", "320x200"]
    done = film(tmp_path, *words, "-o", "frames")
    assert (done.returncode, done.stdout, done.stderr) == (0, "frames\n", "")
    frames = sorted((tmp_path / "frames").iterdir())
    assert [path.name for path in frames] == ["00000.png", "00001.png", "00002.png"]
    pixels = [np.asarray(Image.open(path).convert("RGB")).astype(int) for path in frames]
    assert pixels[0].shape == (200, 320, 3)
    assert (np.abs(pixels[0] - pixels[2]).max(axis=2) > 40).sum() > 50
    if shutil.which("ffmpeg"):
        done = film(tmp_path, *words, "-o", "film.mp4")
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    assert not [path for path in tmp_path.iterdir() if ".part-" in path.name]


@pytest.mark.skipif(browser.PROGRAM is None, reason="there is no Chromium")
def test_bad_input(run, scene, tmp_path):
    """A message, and nothing written."""
    assert run("run", scene.name, "-q").status == 0
    before = sorted(tmp_path.iterdir())
    for words, said, status in (
        (["--size", "321x200"], "321x200", 2),
        (["--from", "1e9"], "not 1e+09 s", 2),
        (["--rate", "0"], "--rate", 2),
        (["--rate", "1e12"], "too many", 2),
        (["-o", "top.h5"], "exists", 74),
    ):
        done = film(tmp_path, "-o", "frames", *words)
        assert (done.returncode, done.stdout) == (status, ""), done.stderr
        assert said in done.stderr
    assert sorted(tmp_path.iterdir()) == before
