# SPDX-FileCopyrightText: The PRISM-VO developers
# SPDX-License-Identifier: BSD-3-Clause
"""report_browser_test.py WRITE_SAMPLE_REPORT: the report of 228 frames in a headless Chromium.

Exit status 77 (skipped) where Chromium or its driver is not installed.
"""

import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time

import browser

# Keys as WebDriver names them.
LEFT = "\ue012"
UP = "\ue013"

# The colours of what the canvas shows: background only, or a picture.
CANVAS_COLORS = """
const canvas = document.querySelector('#view3d canvas');
window.prismReport.view.render();
const gl = canvas.getContext('webgl2') || canvas.getContext('webgl');
const pixels = new Uint8Array(4 * canvas.width * canvas.height);
gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
const colors = new Set();
for (let i = 0; i < pixels.length; i += 4) {
  colors.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]);
}
return colors.size;
"""

# How many pixels of the keyframe's image are not gray: its points.
COLORED_PIXELS = """
const canvas = document.getElementById('keyframe_image');
const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
let count = 0;
for (let i = 0; i < data.length; i += 4) count += Math.abs(data[i] - data[i + 2]) > 60;
return count;
"""


# The plots whose axes do not have two labels each inside their panel.
PLOTS_WITHOUT_LABELS = """
return [...document.querySelectorAll('#plots .panel')].filter(panel => {
  const box = panel.getBoundingClientRect();
  const count = axis => [...panel.querySelectorAll('.dygraph-axis-label-' + axis)].filter(label => {
    const b = label.getBoundingClientRect();
    return label.textContent && b.width > 0 && b.left >= box.left && b.right <= box.right &&
        b.top >= box.top && b.bottom <= box.bottom;
  }).length;
  return count('x') < 2 || count('y') < 2;
}).map(panel => panel.querySelector('h2').textContent);
"""


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def check_page(page, url, width):
    seconds = []
    while len(seconds) < 3 and (not seconds or seconds[-1] > 3):  # other work here only adds
        start = time.monotonic()
        page.open(url)
        check(page.wait_for("document.body.dataset.ready === 'yes'", 30), "the page is not ready")
        seconds.append(time.monotonic() - start)
    seconds = min(seconds)
    check(seconds < 3, f"the page opens in {seconds:.2f} s, not in under 3 s")
    check("sample </script> & <run>" == page.run("return document.title;"), "wrong title")
    check("frames 100 to 103 not tracked (no texture)"
          in page.run("return document.getElementById('problems').textContent;"), "no problems")
    check(page.run("return document.querySelectorAll('.plot canvas').length;") >= 7, "no plots")
    unlabelled = page.run(PLOTS_WITHOUT_LABELS)
    check(not unlabelled, f"plots without axis labels: {unlabelled}")
    colors = page.run(CANVAS_COLORS)
    check(colors > 50, f"the 3D view is blank: {colors} colours")
    overflow = page.run("return document.documentElement.scrollWidth;") - width
    check(overflow <= 0, f"the page is {overflow} px wider than the screen")
    return seconds


def check_keyframes(page):
    # The last keyframe stands at the end of the path, free of others; it is on the screen.
    page.run("document.getElementById('view3d').scrollIntoView({block: 'center'});")
    last = page.run("return window.prismReport.data.keyframes.length - 1;")
    spot = page.run(f"""
        const box = document.querySelector('#view3d canvas').getBoundingClientRect();
        const p = window.prismReport.view.screenPosition({last});
        return {{x: box.left + p.x, y: box.top + p.y}};""")
    page.click(spot["x"], spot["y"])
    shown = "document.getElementById('keyframe_image').dataset.keyframe"
    check(page.wait_for(f"{shown} === '{last}'"), "a click on a keyframe does not show its image")
    check(page.run(COLORED_PIXELS) > 500, "the keyframe's points are not drawn")
    page.run("document.getElementById('view3d').focus();")
    page.press("p")
    check(page.wait_for(f"{shown} === '{last - 1}'"), "the key P does not go to a keyframe")
    page.press("n")
    check(page.wait_for(f"{shown} === '{last}'"), "the key N does not go to a keyframe")
    # Keyframe 2 has no image: from 1 the way goes to 3, and back.
    page.run("document.getElementById('keyframe_slider').value = 1;"
             "document.getElementById('keyframe_slider').oninput("
             "{target: document.getElementById('keyframe_slider')});")
    check(page.wait_for(f"{shown} === '1'"), "the slider does not go to a keyframe")
    page.press("n")
    check(page.wait_for(f"{shown} === '3'"), "N does not go past a keyframe without image")
    page.press("p")
    check(page.wait_for(f"{shown} === '1'"), "P does not go past a keyframe without image")
    where = "return JSON.stringify(window.prismReport.view.screenPosition(0));"
    for key in (LEFT, UP, "+"):
        before = page.run(where)
        page.press(key)
        check(page.run(where) != before, f"the key {key!r} does not move the view")
    check(page.run("""
        const view = document.getElementById('view3d');
        return view.tabIndex === 0 && getComputedStyle(view).outlineStyle !== 'none';"""),
          "the 3D view cannot be reached by keyboard, or does not show that it was")


def check_frames(page):
    """One slider moves the cursor of every plot, the frame in the view and the keyframe shown."""
    page.run("const slider = document.getElementById('frame_slider'); slider.value = 141;"
             "slider.oninput({target: slider});")
    text = page.run("return document.getElementById('frame_text').textContent;")
    check(text.startswith("frame 141 of 228, 4.70 s"), f"the slider shows '{text}'")
    shown = "document.getElementById('keyframe_image').dataset.keyframe"
    expected = page.run("""
        const {data} = window.prismReport;
        return data.keyframes.filter(k => k.t <= data.frames[141].t + 1e-6).length - 1;""")
    check(page.wait_for(f"{shown} === '{expected}'"), "the keyframe of the frame is not shown")
    cursors = page.run("""
        return [...document.querySelectorAll('.cursor')].filter(line => {
          const [a, b] = [line, line.parentElement].map(e => e.getBoundingClientRect());
          return !line.hidden && a.left > b.left && a.right < b.right && a.height > 50;
        }).length;""")
    check(cursors >= 7, f"a cursor in {cursors} plots")
    # A click into a plot goes to the frame there.
    spot = page.run("""
        const plot = document.querySelector('.plot');
        plot.scrollIntoView({block: 'center'});
        const box = plot.getBoundingClientRect();
        return {x: box.left + 0.5 * box.width, y: box.top + 0.5 * box.height};""")
    page.click(spot["x"], spot["y"])
    check(page.wait_for("Math.abs(document.getElementById('frame_slider').value - 115) < 25"),
          "a click into a plot does not go to its frame")


def check_downloads(page):
    tracked = page.run("return window.prismReport.data.frames.filter(f => f.tracked).length;")
    lines = page.run("return window.prismReport.data.trajectory_tum;").splitlines()
    check(len(lines) == tracked and all(len(line.split()) == 8 for line in lines),
          f"{len(lines)} poses to download, {tracked} tracked")
    figures = page.run("""
        return ['rms', 'points', 'a', 'b', 'ms', 'error', 'scale'].filter(name => {
          const page = new DOMParser().parseFromString(window.prismReport.svg(name), 'image/svg+xml');
          return !page.querySelector('parsererror') && page.querySelector('path[d^=M]') &&
              page.querySelectorAll('text').length > 6;
        }).length;""")
    check(figures == 7, f"{figures} of 7 plots are SVG")
    check(page.run("""
        const [header, body] = window.prismReport.plyOf([1, 2, 3, 4, 5, 6], [7, 8]);
        return header.includes('element vertex 2') && body.byteLength === 30 &&
            body.getFloat32(23, true) === 6 && body.getUint8(27) === 8;"""), "the PLY is wrong")
    check(page.run("return !document.getElementById('downloads').hidden;"), "no download buttons")


# The colours of the map that stands for the 3D view.
MAP_COLORS = """
const canvas = document.querySelector('#view3d canvas');
const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
const colors = new Set();
for (let i = 0; i < data.length; i += 4) colors.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
return colors.size;
"""


def check_without_webgl(page, url, width):
    page.open(url)
    check(page.wait_for("document.body.dataset.ready === 'yes'", 30), "the page is not ready")
    check(page.run("return document.createElement('canvas').getContext('webgl') === null;"),
          "there is WebGL")
    check(page.run("return document.querySelectorAll('.tile').length;") >= 5, "no tiles")
    check(page.run("return document.querySelectorAll('.plot canvas').length;") >= 7, "no plots")
    check(not page.run(PLOTS_WITHOUT_LABELS), "plots without axis labels")
    check(page.wait_for("document.getElementById('keyframe_image').dataset.keyframe === '0'"),
          "no keyframe")
    check(page.run("return document.getElementById('no_webgl').offsetParent !== null;"),
          "nothing is said of it")
    colors = page.run(MAP_COLORS)
    check(colors > 50, f"the map is blank: {colors} colours")
    overflow = page.run("return document.documentElement.scrollWidth;") - width
    check(overflow <= 0, f"the page is {overflow} px wider than the screen")
    check_frames(page)
    check_downloads(page)
    errors = [error for error in page.errors() if "WebGL" not in error]
    check(not errors, f"console errors: {errors}")


def check_all_in_view(page):
    outside = page.run("""
        const {data, view} = window.prismReport;
        const box = document.querySelector('#view3d canvas').getBoundingClientRect();
        return data.keyframes.filter((_, i) => {
          const p = view.screenPosition(i);
          return !p.inFront || p.x < 0 || p.y < 0 || p.x > box.width || p.y > box.height;
        }).length;""")
    check(outside == 0, f"{outside} keyframes are out of view at the start")
    check(page.run("return document.getElementById('no_webgl').offsetParent === null;"),
          "the 3D view is said to be none")


def connect(port):
    for _ in range(300):
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
            return
        except OSError:
            time.sleep(0.02)
    raise AssertionError("the live view does not answer")


def check_live(program):
    """The page while a run goes on and after its end, when the server is gone."""
    with browser.Browser() as page:
        port = browser.free_port()
        with subprocess.Popen([program, "--live", str(port)]) as run:
            connect(port)
            page.open(f"http://127.0.0.1:{port}/")
            data = "window.prismReport.data"
            check(page.wait_for(f"{data}.frames.length > 0"), "no frame comes")
            check(page.wait_for(f"{data}.live === false", 20), "the end does not come")
            check(run.wait(20) == 0, "the live view has failed")
        frames = page.run(f"return {data}.frames.length;")
        check(frames == 228, f"{frames} frames, not all 228")
        check(page.wait_for("document.getElementById('title').textContent && "
                            "document.querySelectorAll('.plot canvas').length >= 7"), "no plots")
        # The page is redrawn within half a second.
        check(page.wait_for("document.getElementById('problems').textContent.includes('100 to 103')"),
              "no problems")
        check(page.wait_for("!document.getElementById('summary').textContent.includes('running')"),
              "still running")
        check_keyframes(page)
        check(not page.errors(), f"console errors: {page.errors()}")
        print(f"live: {frames} frames")


def main():
    missing = browser.missing_programs()
    if missing:
        print(f"skipped: {' and '.join(missing)} not installed (apt-get install chromium-driver)")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.html"
        subprocess.run([sys.argv[1], str(report)], check=True)
        mib = report.stat().st_size / 2**20
        check(mib < 15, f"the report has {mib:.1f} MiB, not under 15")
        for name, width, dark in (("desktop", 1280, False), ("phone", 390, False),
                                  ("dark", 1280, True)):
            with browser.Browser(width, 900, dark) as page:
                seconds = check_page(page, report.as_uri(), width)
                check_all_in_view(page)
                check_keyframes(page)
                check_frames(page)
                check_downloads(page)
                if "PRISM_SCREENSHOTS" in os.environ:
                    shots = pathlib.Path(os.environ["PRISM_SCREENSHOTS"])
                    page.run("window.scrollTo(0, 0);")
                    page.screenshot(shots / f"{name}.png", whole_page=True)
                check(not page.errors(), f"console errors: {page.errors()}")
                print(f"{name}: {mib:.1f} MiB, ready in {seconds:.2f} s")
        for width in (1400, 390):
            with browser.Browser(width, 900, webgl=False) as page:
                check_without_webgl(page, report.as_uri(), width)
                if "PRISM_SCREENSHOTS" in os.environ:
                    shots = pathlib.Path(os.environ["PRISM_SCREENSHOTS"])
                    page.run("window.scrollTo(0, 0);")
                    page.screenshot(shots / f"no_webgl_{width}.png", whole_page=True)
                print(f"without WebGL, {width} px: tiles, plots, keyframes, map")
    check_live(sys.argv[1])
    return 0


if __name__ == "__main__":
    sys.exit(main())
