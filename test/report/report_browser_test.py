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

# `pixels` of what the 3D view's canvas shows.
VIEW_PIXELS = """
const canvas = document.querySelector('#view3d canvas');
window.prismReport.view.render();
const gl = canvas.getContext('webgl2') || canvas.getContext('webgl');
const pixels = new Uint8Array(4 * canvas.width * canvas.height);
gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
"""

# The same of the map that stands for it.
MAP_PIXELS = """
const canvas = document.querySelector('#view3d canvas');
const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
"""

# How many colours: one of background only, or those of a picture.
CANVAS_COLORS = VIEW_PIXELS + """
const colors = new Set();
for (let i = 0; i < pixels.length; i += 4) {
  colors.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]);
}
return colors.size;
"""

# A number that tells one picture from another.
SUM = "return pixels.reduce((sum, value) => (31 * sum + value) % 1000000007, 0);"
CANVAS_SUM = VIEW_PIXELS + SUM
MAP_SUM = MAP_PIXELS + SUM

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
    # Processor time of the page: the wall says more of what else the machine does.
    page.cdp("Performance.enable", {"timeDomain": "threadTicks"})
    page.open(url)
    check(page.wait_for("document.body.dataset.ready === 'yes'", 60), "the page is not ready")
    metrics = page.cdp("Performance.getMetrics", {})["metrics"]
    seconds = next(m["value"] for m in metrics if m["name"] == "TaskDuration")
    check(0 < seconds < 3, f"the page opens in {seconds:.2f} s of the processor, not in under 3 s")
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


def choose(page, name, value):
    page.run(f"const list = document.getElementById('{name}'); list.value = '{value}';"
             "list.onchange();")


# Width of a map, and three of its pixels: one that is not measured, one left, one right.
DEPTH_MAP_PIXELS = """
const canvas = document.querySelector('#%s canvas');
const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
const pixel = (x, y) => [...data.slice(4 * (y * canvas.width + x), 4 * (y * canvas.width + x) + 4)];
return [canvas.width, pixel(1, 250), pixel(150, 3), pixel(250, 3)];
"""


def check_keyframe_depth(page):
    """1/v and its sigma beside the keyframe, and its points by residual."""
    page.run("const slider = document.getElementById('keyframe_slider'); slider.value = 1;"
             "slider.oninput({target: slider});")
    for name, low in (("depth_map", "0.3"), ("sigma_map", "0.002")):
        check(page.wait_for(f"document.querySelector('#{name} canvas').width === 256"),
              f"no {name}")
        text = page.run(f"return document.querySelector('#{name} figcaption').textContent;")
        check(low in text, f"the legend of {name} says '{text}'")
    width, none, left, right = page.run(DEPTH_MAP_PIXELS % "depth_map")
    check(none[3] == 0, f"not measured, and drawn as {none}")
    # 1/v rises to the right: from yellow towards violet.
    check(left[3] == 255 and left[0] > right[0] + 50, f"1/v is {left} left, {right} right")
    legend = "document.getElementById('depth_legend').textContent"
    check(page.run(f"return {legend};").endswith(" m"), "no metres")
    choose(page, "point_color", "residual")
    check(page.wait_for("document.getElementById('keyframe_image').dataset.color === 'residual'"),
          "points are not coloured by residual")
    check("7.6 intensities" in page.run(f"return {legend};"), "no unit of residuals")
    check(page.run(COLORED_PIXELS) > 500, "the points' residuals are not drawn")
    choose(page, "point_color", "")
    check(page.wait_for("document.getElementById('keyframe_image').dataset.color === ''"),
          "points are not left out")
    check(page.run(COLORED_PIXELS) == 0, "points where none are wanted")
    choose(page, "point_color", "depth")


def check_path_colors(page, colors_of_view):
    """The path by time, error and residual, each with its legend."""
    legend = "return document.getElementById('path_legend').textContent;"
    if page.run("return document.getElementById('no_webgl').hidden;"):
        check(page.wait_for("document.getElementById('view3d').dataset.picture === 'shown'"),
              "the keyframe's picture does not come")
    plain = page.run(colors_of_view)
    for name, low, high in (("time", "0.0 s", "7.6 s"), ("error", "0.0 mm", " mm"),
                            ("residual", "4.0", "6.0 intensities")):
        choose(page, "path_color", name)
        text = page.run(legend)
        check(low in text and text.endswith(high), f"the path by {name} has the legend '{text}'")
        check(page.run(colors_of_view) != plain, f"the path is not coloured by {name}")
    choose(page, "path_color", "")
    check(page.run(legend) == "estimate", "the legend of the plain path is wrong")
    check(page.run(colors_of_view) == plain, "the path keeps colours")


def check_layers(page, colors_of_view):
    """Dense points, those of the odometry, none; the picture in the keyframe's pyramid."""
    check(page.run("return document.getElementById('cloud_choice').value;") == "dense",
          "dense points are not shown first")
    seen = set()
    for name in ("dense", "cloud", ""):
        choose(page, "cloud_choice", name)
        seen.add(str(page.run(colors_of_view)))
    check(len(seen) == 3, "the choice of points changes nothing")
    if page.run("return document.getElementById('no_webgl').hidden;"):
        with_picture = page.run(colors_of_view)
        page.run("document.getElementById('show_picture').click();")
        check(page.run(colors_of_view) != with_picture, "no picture in the keyframe's pyramid")
        page.run("document.getElementById('show_picture').click();")
        check(page.run(colors_of_view) == with_picture, "the picture does not come back")
    choose(page, "cloud_choice", "dense")


def check_tiles(page):
    tiles = page.run("return document.getElementById('tiles').textContent;")
    check("± 1.23 %metric scale" in tiles, f"the stated scale is not among the tiles: {tiles}")


def check_long_run(program, folder):
    """Of 10,000 frames, which are not all in the page."""
    report = pathlib.Path(folder) / "long.html"
    subprocess.run([program, str(report), "10000"], check=True)
    size = report.stat().st_size
    check(size < 20e6, f"the report of 10,000 frames has {size / 1e6:.1f} MB")
    with browser.Browser(1400, 900) as page:
        page.open(report.as_uri())
        check(page.wait_for("document.body.dataset.ready === 'yes'", 30), "the page is not ready")
        left_out = page.run("return document.getElementById('left_out').innerText;")
        check("one in 2 of the 10000 frames is shown" in left_out, f"left out: '{left_out}'")
        check("keyframes have their picture here" in left_out, f"left out: '{left_out}'")
        summary = page.run("return document.getElementById('summary').textContent;")
        check("9996 of 10000 frames tracked, 1999 keyframes" in summary, summary)
        page.run("const slider = document.getElementById('frame_slider'); slider.value = 4000;"
                 "slider.oninput({target: slider});")
        text = page.run("return document.getElementById('frame_text').textContent;")
        check(text.startswith("frame 8000 of 10000, 266.67 s"), f"the slider shows '{text}'")
        shown = "document.getElementById('keyframe_image').dataset.keyframe"
        page.run("document.getElementById('keyframe_slider').value = 101;"
                 "document.getElementById('keyframe_slider').oninput("
                 "{target: document.getElementById('keyframe_slider')});")
        check(page.wait_for(f"Number({shown}) <= 101") and
              page.run(f"return Boolean(window.prismReport.data.keyframes[{shown}].jpeg);"),
              "the way through keyframes does not go from picture to picture")
        rows = page.run("return document.getElementById('stages').innerText;")
        check("10000" in rows, f"stage times are not those of all frames: {rows}")
        check(not page.errors(), f"console errors: {page.errors()}")
        print(f"10,000 frames: {size / 1e6:.1f} MB")


def check_downloads(page):
    tracked = page.run("return window.prismReport.data.frames.filter(f => f.tracked).length;")
    lines = page.run("return window.prismReport.data.trajectory_tum;").splitlines()
    check(len(lines) == tracked and all(len(line.split()) == 8 for line in lines),
          f"{len(lines)} poses to download, {tracked} tracked")
    figures = page.run("""
        return ['rms', 'points', 'a', 'b', 'ms', 'error', 'scale', 'scale_sigma'].filter(name => {
          const page = new DOMParser().parseFromString(window.prismReport.svg(name), 'image/svg+xml');
          return !page.querySelector('parsererror') && page.querySelector('path[d^=M]') &&
              page.querySelectorAll('text').length > 6;
        }).length;""")
    check(figures == 8, f"{figures} of 8 plots are SVG")
    check(page.run("""
        const [header, body] =
            window.prismReport.plyOf([1, 2, 3, 4, 5, 6], [7, 8, 9, 10, 11, 12]);
        return header.includes('element vertex 2') && body.byteLength === 30 &&
            body.getFloat32(23, true) === 6 && body.getUint8(12) === 7 && body.getUint8(29) === 12;
        """), "the PLY is wrong")
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
    check_tiles(page)
    check_keyframe_depth(page)
    check_path_colors(page, MAP_SUM)
    check_layers(page, MAP_SUM)
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
                if not dark:
                    check_tiles(page)
                    check_keyframe_depth(page)
                    check_path_colors(page, CANVAS_SUM)
                    check_layers(page, CANVAS_SUM)
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
        check_long_run(sys.argv[1], folder)
    check_live(sys.argv[1])
    return 0


if __name__ == "__main__":
    sys.exit(main())
