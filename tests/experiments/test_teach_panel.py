"""A browser clicks, the panel reads."""

import time

import pytest
from browser_driver import Browser

from vh_drake.experiments.teach_panel import (
    ACTION_BUTTONS,
    FINGER_SLIDERS,
    JOG_BUTTONS,
    SLIDERS,
    TeachPanel,
    Touched,
)
from vh_drake.hand.teaching import JOGS
from vh_drake.scenes.showing import make_meshcat


@pytest.fixture(scope="module")
def panel():
    """One panel, shown by one browser."""
    meshcat = make_meshcat()
    panel = TeachPanel(meshcat)
    with Browser(meshcat.web_url()) as browser:
        browser.click("Open Controls")
        panel.browser = browser
        yield panel
    panel.close()


def read(panel, buttons=0, sliders=0, limit_s=20.0):
    """All that happens until as many clicks and moved sliders have come."""
    clicked, moved, end = (), {}, time.monotonic() + limit_s
    while (len(clicked) < buttons or len(moved) < sliders) and time.monotonic() < end:
        touched = panel.read()
        clicked, moved = clicked + touched.buttons, moved | touched.sliders
        time.sleep(0.02)
    return Touched(clicked, moved)


def test_clicks_are_read_once(panel):
    panel.browser.click("forward")
    panel.browser.click("set key point")
    panel.browser.click("forward")
    assert sorted(read(panel, buttons=3).buttons) == ["forward", "forward", "set key point"]
    assert panel.read() == Touched()


def test_keys_do_what_buttons_and_sliders_do(panel):
    panel.browser.press("e", "KeyE")
    panel.browser.press("g", "KeyG")
    assert read(panel, buttons=1, sliders=1) == Touched(("up",), {"fingers [%]": 2.0})
    assert panel.value("fingers [%]") == 2.0


def test_a_slider_that_was_shown_a_value_is_no_act_of_the_user(panel):
    panel.show_value("thumb [%]", 40.0)
    panel.browser.click("save")
    assert read(panel, buttons=1) == Touched(("save",))
    panel.browser.press("b", "KeyB")  # It goes on from where the page shows it.
    assert read(panel, sliders=1).sliders == {"thumb [%]": 42.0}


def test_a_value_within_a_slider_s_step_leaves_it_alone(panel):
    before = panel.value("step [mm]")
    panel.show_value("step [mm]", before + 0.4)
    assert panel.value("step [mm]") == before
    assert panel.read() == Touched()


def test_every_jog_can_be_made_in_both_senses():
    by_button = {name: set() for name, _, _ in JOG_BUTTONS.values()}
    for name, sense, _ in JOG_BUTTONS.values():
        by_button[name].add(sense)
    assert all(senses == {1, -1} for senses in by_button.values())
    assert set(by_button) | set(FINGER_SLIDERS.values()) == set(JOGS)


def test_no_key_does_two_things():
    keys = [key for _, _, key in JOG_BUTTONS.values()] + list(ACTION_BUTTONS.values())
    keys += [key for *_, less, more in SLIDERS.values() for key in (less, more)]
    keys = [key for key in keys if key]
    assert len(set(keys)) == len(keys)
