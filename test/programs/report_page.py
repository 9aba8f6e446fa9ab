# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""Opens a report in a real browser, by software rendering: no error and no request, points with colours, controls that
change them, and no width at which it must be scrolled sideways.

report_page.py REPORT.html [SCREENSHOT.png]
"""
import json
import pathlib
import sys
import time

from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

PIXELS = """
const canvas = document.getElementById('viewer'), gl = canvas.getContext('webgl2');
const pixels = new Uint8Array(4 * canvas.width * canvas.height);
gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
let painted = 0, sum = [0, 0, 0];
for (let i = 0; i < pixels.length; i += 4) {
  if (pixels[i] === 16 && pixels[i + 1] === 21 && pixels[i + 2] === 28) continue;
  ++painted; for (let c = 0; c < 3; ++c) sum[c] += pixels[i + c];
}
return [painted / (pixels.length / 4), ...sum.map(s => s / Math.max(1, painted))];
"""

options = webdriver.ChromeOptions()
for argument in ("--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader", "--window-size=1280,900"):
    options.add_argument(argument)
options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
driver = webdriver.Chrome(options=options)
problems = []


def check(what, holds):
    if not holds:
        problems.append(what)


def frames():
    return int(driver.execute_script("return document.getElementById('viewer').dataset.frames || 0"))


def wait_for_frame(after):
    """Until more than `after` frames were painted; a slow machine takes its time."""
    end = time.time() + 60
    while frames() <= after and time.time() < end:
        time.sleep(0.05)


def painted(act=lambda: None):
    """What the canvas shows once the action had its effect: share of it that is painted, mean colour of that."""
    before = frames()
    act()
    wait_for_frame(before)
    time.sleep(0.2)  # a key that repeats paints several
    return driver.execute_script(PIXELS)


try:
    page = pathlib.Path(sys.argv[1]).resolve()
    start = time.time()
    driver.get(page.as_uri())
    wait_for_frame(0)
    print(f"first frame after {time.time() - start:.1f} s")
    check("nothing is painted", frames() > 0)
    facts = json.loads(driver.execute_script("return document.getElementById('facts').textContent"))
    first = driver.execute_script(PIXELS)
    check(f"the canvas is empty: {first}", first[0] > 0.005)
    check("a light is missing", len(driver.find_elements(By.CSS_SELECTOR, "#lights .card")) == len(facts["lights"]))
    check("a picture is broken", driver.execute_script(
        "return [...document.images].every(image => image.naturalWidth > 0)"))
    by = Select(driver.find_element(By.ID, "by"))
    for choice in ("1", "2", "3"):
        now = painted(lambda: by.select_by_value(choice))
        check(f"colour by {choice} shows nothing else", max(abs(a - b) for a, b in zip(first[1:], now[1:])) > 3)
    painted(lambda: by.select_by_value("0"))
    canvas = driver.find_element(By.ID, "viewer")
    near = painted(lambda: canvas.send_keys("++++++"))
    check(f"keys do not zoom: {first[0]} {near[0]}", abs(near[0] - first[0]) > 0.002)
    at_home = painted(driver.find_element(By.ID, "home").click)
    check("the button does not lead home", abs(at_home[0] - first[0]) < 0.001)
    everything = painted(driver.find_element(By.ID, "uncolored").click)
    check("points without colour do not appear", everything[0] > first[0])
    painted(driver.find_element(By.ID, "uncolored").click)
    size = driver.find_element(By.ID, "size")
    larger = painted(lambda: driver.execute_script(
        "arguments[0].value = 12; arguments[0].dispatchEvent(new Event('input'))", size))
    check("the size does nothing", larger[0] > first[0])
    canvas.click()
    said = driver.find_element(By.ID, "picked").text
    check(f"a click tells nothing: {said}", said.startswith("Point at") or said == "No point there.")
    for element in driver.find_elements(By.CSS_SELECTOR, "input, select, canvas, svg, img"):
        name = element.accessible_name
        check(f"<{element.tag_name}> has no name for a screen reader", bool(name))
    for width in (360, 1600):
        driver.set_window_size(width, 900)
        time.sleep(0.3)
        wide, inner = driver.execute_script("return [document.documentElement.scrollWidth, window.innerWidth]")
        check(f"at {width} px the page is {wide} px wide", wide <= inner)
    driver.set_window_size(1280, 900)
    if len(sys.argv) > 2:
        driver.execute_script("window.scrollTo(0, 0)")
        driver.save_screenshot(sys.argv[2])
    errors = [entry["message"] for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "ERROR")]
    check(f"the console has errors: {errors}", not errors)
    requests = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    urls = [event["params"]["request"]["url"] for event in requests if event["method"] == "Network.requestWillBeSent"]
    foreign = [url for url in urls if not url.startswith((page.as_uri(), "data:"))]
    check(f"it asks for {foreign}", not foreign)
finally:
    driver.quit()
print("\n".join(problems) or "the page is as it should be")
sys.exit(bool(problems))
