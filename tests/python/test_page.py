"""The page in the FMU, as a browser lays it out; skipped if there is no chromium."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from browsing import QUIET, chromium
from fmpy import read_model_description
from fmu import Package
from PIL import Image

# A script that writes its results into the page, from whose text they are read.
PROBE = """
<script>
addEventListener("load", () => {
  const width = document.documentElement.clientWidth;
  const visible = element => {
    const box = element.getBoundingClientRect();
    return box.width > 0 && box.height > 0 && box.left >= 0 && box.right <= width;
  };
  const names = [...document.querySelectorAll("td:first-child code")];
  const links = [...document.querySelectorAll("nav a")];
  document.body.append(Object.assign(document.createElement("pre"), {id: "probe",
    textContent: JSON.stringify({
      width, scroll: document.documentElement.scrollWidth,
      names: names.filter(visible).map(name => name.textContent),
      picture: document.querySelector("header img").naturalWidth,
      dead: links.filter(link => !document.querySelector(link.getAttribute("href"))).length,
      links: links.length,
      marks: document.body.textContent.match(/@[A-Z]+@/g),
    })}));
});
</script>
"""


@pytest.fixture(scope="module")
def page(package: Package, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy with the probe, beside a copy of the picture that it shows."""
    folder = tmp_path_factory.mktemp("page")
    shutil.copytree(Path(package.folder) / "terminalsAndIcons", folder / "terminalsAndIcons")
    text = (Path(package.folder) / "documentation" / "index.html").read_text(encoding="utf-8")
    copy = folder / "documentation" / "index.html"
    copy.parent.mkdir()
    copy.write_text(text.replace("</body>", PROBE + "</body>"), encoding="utf-8")
    return copy


def browse(page: Path, width: int, *more: str) -> str:
    """Returns the browser's output."""
    profile = page.parent / f"profile-{width}"
    command = [chromium(), *QUIET, f"--user-data-dir={profile}", f"--window-size={width},2000"]
    done = subprocess.run(
        [*command, *more, page.as_uri()], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("width", [1200, 500])
def test_everything_is_there_and_nothing_sticks_out(page: Path, fmu_path: Path, width: int) -> None:
    text = browse(page, width, "--dump-dom")
    found = re.search(r'<pre id="probe">(.*?)</pre>', text, re.DOTALL)
    assert found is not None, text[-2000:]
    layout = json.loads(unescape(found.group(1)))
    assert layout["width"] == width
    assert layout["scroll"] <= width
    variables = {v.name for v in read_model_description(str(fmu_path)).modelVariables}
    assert variables <= set(layout["names"])
    assert layout["picture"] > 0
    assert layout["links"] > 0
    assert layout["dead"] == 0
    assert layout["marks"] is None


def test_the_page_is_painted(page: Path, tmp_path: Path) -> None:
    picture = tmp_path / "page.png"
    browse(page, 1200, f"--screenshot={picture}")
    pixels = np.asarray(Image.open(picture).convert("L"), dtype=float)
    assert pixels.shape == (2000, 1200)
    # Every stretch as high as a heading and its gaps has some text.
    background = np.median(pixels)
    inked = (np.abs(pixels - background) > 60).mean(axis=1)
    assert all(stretch.sum() > 0 for stretch in np.split(inked, 10))
    assert 0.01 < inked.mean() < 0.4
