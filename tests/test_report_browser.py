"""The web page of a run in a real browser: no errors, it moves, it is zoomed, keys work, it can be read."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tcontact.commands.cli import main

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
waiting = pytest.importorskip("selenium.webdriver.support.ui")
CHROME = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(CHROME is None or DRIVER is None, reason="neither Chromium nor its driver is installed")
SURFACE = "return document.querySelector('.view canvas').toDataURL()"


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """Of two small cubes that meet."""
    place = tmp_path_factory.mktemp("browser") / "run"
    settings = ["--set", "cells=2", "--set", "cfl=0.5", "--frames", "5", "--quiet", "--out", str(place)]
    assert main(["run", "cube-impact", *settings]) in (0, 1)
    assert main(["report", str(place)]) == 0
    return place / "report.html"


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """A function that starts a browser with more arguments."""
    started = []

    def go(*arguments):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROME
        usual = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1200,1000")
        profile = f"--user-data-dir={tmp_path_factory.mktemp('profile')}"
        for argument in (*usual, profile, *arguments):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        browser = webdriver.Chrome(service=webdriver.ChromeService(DRIVER), options=options)
        started.append(browser)
        return browser

    yield go
    for browser in started:
        browser.quit()


@pytest.fixture(scope="module")
def browser(start):
    return start("--use-angle=swiftshader", "--enable-unsafe-swiftshader")


@pytest.fixture
def opened(browser, page):
    """The page, read anew."""
    browser.get(page.as_uri())
    assert browser.execute_script("return document.documentElement.dataset.ready") == "yes"
    return browser


def find(browser, selector):
    return browser.find_element("css selector", selector)


def press(browser, selector, *keys):
    """Press keys while an element has the focus."""
    place = find(browser, selector)
    browser.execute_script("arguments[0].focus()", place)
    webdriver.ActionChains(browser).send_keys(*keys).perform()


def test_there_are_no_errors_and_nothing_is_fetched(opened):
    assert [entry for entry in opened.get_log("browser") if entry["level"] != "DEBUG"] == []
    fetched = opened.execute_script("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [name for name in fetched if not name.startswith("data:")] == []


def test_the_slider_moves_film_surface_and_curves(opened):
    before = [opened.execute_script(SURFACE), find(opened, ".film").get_attribute("src")]
    cursor = find(opened, ".figure .now").get_attribute("x1")
    press(opened, "input[type=range]", webdriver.Keys.HOME)
    after = [opened.execute_script(SURFACE), find(opened, ".film").get_attribute("src")]
    assert all(one != other for one, other in zip(before, after, strict=True))
    assert find(opened, ".figure .now").get_attribute("x1") != cursor
    assert find(opened, ".clock").text == "0 s"
    press(opened, "input[type=range]", webdriver.Keys.ARROW_RIGHT)
    assert "frame 2 of" in find(opened, "input[type=range]").get_attribute("aria-valuetext")
    press(opened, "input[type=range]", " ")
    assert find(opened, ".bar button[aria-pressed]").text == "Pause"
    waiting.WebDriverWait(opened, 20).until(lambda seen: find(seen, ".film").get_attribute("src") not in after)


def test_the_surface_turns_by_mouse_and_keys_and_shows_other_fields(opened):
    seen = [opened.execute_script(SURFACE)]
    canvas = find(opened, ".view canvas")
    webdriver.ActionChains(opened).drag_and_drop_by_offset(canvas, 80, 20).perform()
    seen.append(opened.execute_script(SURFACE))
    for key in (webdriver.Keys.ARROW_LEFT, webdriver.Keys.ARROW_UP, "+"):
        press(opened, ".view", key)
        seen.append(opened.execute_script(SURFACE))
    [speed] = [one for one in opened.find_elements("css selector", "option") if one.text == "Speed"]
    speed.click()
    seen.append(opened.execute_script(SURFACE))
    assert "m/s" in find(opened, ".scale").text
    find(opened, "input[type=checkbox]").click()
    seen.append(opened.execute_script(SURFACE))
    assert len(set(seen)) == len(seen) == 7
    [button] = [one for one in opened.find_elements("css selector", "button") if one.text == "Reset view"]
    button.click()
    assert opened.execute_script(SURFACE) not in seen


def test_curves_are_zoomed_by_keys_wheel_and_drag(opened):
    path = "return document.querySelector('.figure .curve').getAttribute('d')"
    whole = opened.execute_script(path)
    press(opened, ".figure svg", "+")
    nearer = opened.execute_script(path)
    press(opened, ".figure svg", webdriver.Keys.ARROW_RIGHT)
    moved = opened.execute_script(path)
    assert len({whole, nearer, moved}) == 3
    press(opened, ".figure svg", "0")
    assert opened.execute_script(path) == whole
    svg = find(opened, ".figure svg")
    webdriver.ActionChains(opened).move_to_element(svg).click_and_hold().move_by_offset(60, 0).release().perform()
    dragged = opened.execute_script(path)
    assert dragged != whole
    webdriver.ActionChains(opened).double_click(svg).perform()
    assert opened.execute_script(path) == whole
    origin = webdriver.common.actions.wheel_input.ScrollOrigin.from_element(svg)
    webdriver.ActionChains(opened).scroll_from_origin(origin, 0, -120).perform()
    assert opened.execute_script(path) != whole


def test_every_control_is_reached_by_tab_and_has_a_name(opened):
    reached = set()
    for _ in range(40):
        webdriver.ActionChains(opened).send_keys(webdriver.Keys.TAB).perform()
        reached.add(opened.execute_script("return document.activeElement.tagName + document.activeElement.className"))
    assert {"DIVview", "SELECT", "BUTTON", "INPUT"} <= reached
    assert any(name.startswith("svg") for name in reached)
    nameless = """return [...document.querySelectorAll('button, select, input, svg, img, [tabindex]')].filter(
        one => !(one.getAttribute('aria-label') || one.getAttribute('alt') || one.textContent.trim()
                 || one.closest('label'))).map(one => one.outerHTML.slice(0, 80))"""
    assert opened.execute_script(nameless) == []


CONTRAST = """
const light = text => { const [r, g, b] = text.match(/[\\d.]+/g).map(Number).map(v => v / 255)
  .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const behind = one => { for (; one; one = one.parentElement) { const c = getComputedStyle(one).backgroundColor;
  if (!/rgba\\(.*, 0\\)/.test(c)) return c; } return 'rgb(255, 255, 255)'; };
return [...document.querySelectorAll('h1, h2, h3, p, td, th, button, select, output, label, b, text, span')]
  .filter(one => one.textContent.trim() && one.getClientRects().length).map(one => {
    const style = getComputedStyle(one), b = light(behind(one));
    const a = light(one.tagName === 'text' ? style.fill : style.color);
    return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), one.tagName, one.textContent.slice(0, 30)];
  }).sort((a, b) => a[0] - b[0])[0]"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_have_contrast(scheme, opened):
    features = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", features)
    worst = opened.execute_script(CONTRAST)
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    assert worst[0] >= 4.5, worst


def test_a_narrow_screen_needs_no_sideways_scrolling(opened):
    size = {"width": 360, "height": 740, "deviceScaleFactor": 1, "mobile": True}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    width = opened.execute_script("return document.documentElement.scrollWidth")
    opened.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert width <= 360


def test_without_webgl_the_film_still_plays(start, page):
    plain = start("--disable-gpu", "--disable-3d-apis")
    plain.get(page.as_uri())
    assert plain.execute_script("return document.documentElement.dataset.ready") == "yes"
    assert "no WebGL" in find(plain, ".card").text
    press(plain, "input[type=range]", webdriver.Keys.HOME)
    assert find(plain, ".clock").text == "0 s"
