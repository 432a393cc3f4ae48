"""A hand that is taught: by a script, and by the clicks of a browser."""

import subprocess
import sys
import time

import numpy as np
import pytest
from browser_driver import Browser

from vh_drake.errors import BadInput
from vh_drake.experiments.teach_command import UNSAVED, teach
from vh_drake.experiments.teach_panel import SLIDERS, Touched
from vh_drake.experiments.teach_session import TICK_S, TeachSession
from vh_drake.hand.key_points import KeyPoint, load_key_points
from vh_drake.objects.loading import load_object
from vh_drake.scenes.scenario import Placement, Scenario
from vh_drake.scenes.teaching import make_teaching_scene

LIMIT_S = 180.0
SETTLE_S = 0.7  # many ticks of the session: within one the order of two clicks is lost
SCENARIO = Scenario(contact="point", object="sugar_box")


class Script:
    """Stands in for the panel: gives what a user does, keeps what a user would see."""

    def __init__(self):
        self.ahead, self.texts, self.paths = [], [], []
        self.values = {label: values[3] for label, values in SLIDERS.items()}

    def read(self):
        touched = self.ahead.pop(0) if self.ahead else Touched()
        self.values |= touched.sliders
        return touched

    def value(self, label):
        return self.values[label]

    def show_value(self, label, value):
        self.values[label] = value

    def show_text(self, text):
        self.texts.append(text)

    def show_path(self, p_WP, selected):
        self.paths.append((p_WP, selected))


class Taught:
    """A session that follows a script."""

    def __init__(self, scene, file):
        self.panel, self.lines = Script(), []
        self.session = TeachSession(scene, self.panel, file, self.lines.append)

    def do(self, *buttons, wait_s=0.0, **sliders):
        moved = {f"{name} [%]": value for name, value in sliders.items()}
        self.panel.ahead.append(Touched(buttons, moved))
        for _ in range(1 + round(wait_s / TICK_S)):
            assert self.session.tick()
        return self

    def until(self, text, limit_s):
        """Waits for a line that holds a text."""
        for _ in range(round(limit_s / TICK_S)):
            if any(text in line for line in self.lines):
                return self
            self.do()
        raise TimeoutError(text)

    @property
    def teaching(self):
        return self.session.teaching

    def hand_pose(self):
        scene = self.session._scene
        return scene.diagram.GetOutputPort("hand_pose").Eval(scene.context).GetAsMatrix4()


@pytest.fixture(scope="module")
def taught(tmp_path_factory):
    """One robot for all tests of this file, its hand over the object."""
    scene = make_teaching_scene(SCENARIO, load_object("sugar_box"))
    taught = Taught(scene, tmp_path_factory.mktemp("teach") / "box.yaml")
    taught.session.start()
    return taught


@pytest.mark.slow
def test_the_hand_starts_over_the_object_with_its_tips_level(taught):
    X_WH, session = taught.hand_pose(), taught.session
    np.testing.assert_allclose(X_WH, session.X_WH0, atol=5e-3)
    hand = session._scene.hand
    tips = hand.spheres(hand.lower)[0][hand.tip_spheres] @ X_WH[:3, :3].T + X_WH[:3, 3]
    assert np.ptp(tips[[0, -1], 2]) < 0.03


@pytest.mark.slow
def test_jogs_move_the_simulated_hand_by_their_steps(taught):
    before = taught.hand_pose()
    taught.do("up", "up", wait_s=1.0)
    after = taught.hand_pose()
    np.testing.assert_allclose(after[:3, 3] - before[:3, 3], [0, 0, 0.010], atol=1.5e-3)
    assert taught.lines[-1].endswith("up 10 mm")
    taught.do("fingertips down", wait_s=1.0)
    assert taught.lines[-1].endswith("up 10 mm, pitch 3 deg")
    fingers = taught.hand_pose()[:3, 2]
    angle = np.arccos(fingers @ after[:3, 2])
    assert np.rad2deg(angle) == pytest.approx(3.0, abs=0.3)
    assert fingers[2] < after[2, 2]


@pytest.mark.slow
def test_fingers_close_as_the_sliders_say(taught):
    taught.do(fingers=40.0, thumb=20.0, wait_s=1.5)
    scene = taught.session._scene
    port = scene.station.GetOutputPort("motor_fraction")
    fractions = port.Eval(scene.station.GetMyContextFromRoot(scene.context))
    np.testing.assert_allclose(fractions, [0.4, 0.2], atol=0.03)
    taught.do(fingers=0.0, thumb=0.0, wait_s=0.8)


@pytest.mark.slow
def test_a_lowered_hand_stops_where_it_touches(taught):
    before = taught.hand_pose()[2, 3]
    taught.do("lower until touch").until("touched", limit_s=8.0)
    sunk = before - taught.hand_pose()[2, 3]
    assert 0.01 < sunk < 0.15
    taught.do(wait_s=0.5)
    assert before - taught.hand_pose()[2, 3] == pytest.approx(sunk, abs=2e-3)


@pytest.mark.slow
def test_key_points_are_set_saved_loaded_and_played(taught):
    session = taught.session
    taught.do("set key point")
    first = taught.teaching.points[0]
    assert first.position_m == [0.0, 0.0, 0.0]
    assert first.rpy_deg == [0.0, 0.0, 0.0]
    taught.do("up", "up", "up", "up", "up", "up", wait_s=0.5).do("set key point", "back")
    taught.do(fingers=30.0).do("set key point", "set key point", "delete key point")
    times = [point.time_s for point in taught.teaching.points]
    assert times == [0.0, 0.5, 1.0]
    taught.do("save")
    kept = load_key_points(session._file).key_points
    assert kept == list(taught.teaching.points)
    assert kept[2] == KeyPoint(1.0, 0.3, 0.0, [-0.005, 0.0, 0.03], [0.0, 0.0, 0.0])
    X_start = session.X_WH0.copy()
    taught.do("delete key point", "delete key point", "delete key point")
    assert taught.teaching.points == ()
    taught.do("play")
    assert "no key points" in taught.lines[-1]
    taught.do("load")
    assert list(taught.teaching.points) == kept
    np.testing.assert_allclose(session.X_WH0[:3, 3] - X_start[:3, 3], [-0.005, 0, 0.03], atol=1e-6)
    taught.do("play", wait_s=0.1)
    assert taught.teaching.playing_s < 0
    taught.do(wait_s=3.0)
    assert "played" in taught.lines[-1]
    height = taught.hand_pose()[2, 3] - session.X_WH0[2, 3]
    assert height == pytest.approx(0.03, abs=2e-3)
    p_WP, selected = taught.panel.paths[-1]
    np.testing.assert_allclose(np.diff(p_WP[:, 2]), [0.03, 0.0], atol=1e-6)
    assert selected == 2


@pytest.mark.slow
def test_a_file_that_can_not_be_read_is_told_and_spoils_nothing(taught):
    points = taught.teaching.points
    taught.session._file.write_text("key_points: [{fingers: 7}]")
    taught.do("load")
    assert "fingers is 7" in taught.lines[-1]
    assert taught.teaching.points == points


def test_an_object_out_of_reach_is_told_before_anything_starts(tmp_path):
    far = Scenario(contact="point", object="sugar_box", placement=Placement(center=[1.6, -0.3]))
    with pytest.raises(BadInput, match="nearer"):
        make_teaching_scene(far, load_object("sugar_box"))


def test_a_spoilt_file_and_a_folder_are_told_before_the_page_is_served(tmp_path):
    (tmp_path / "a.yaml").write_text("key_points: []")
    for path, message in ((tmp_path / "a.yaml", "0 key points"), (tmp_path, "is a folder")):
        with pytest.raises(BadInput, match=message):
            teach(SCENARIO, path, host="localhost", tell=print)


class Command:
    """The command `teach` in a process of its own, and what it has printed."""

    def __init__(self, file, log):
        self._log = log
        arguments = [str(file), "--object", "sugar_box"]
        with log.open("w") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "vh_drake", "teach", *arguments],
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()

    def lines(self):
        """All but Drake's own warnings, which come at any time."""
        lines = self._log.read_text().splitlines()
        return [line for line in lines if not line.startswith("WARNING:drake")]

    def wait_for(self, condition, limit_s=LIMIT_S):
        """The lines, once they meet a condition."""
        end = time.monotonic() + limit_s
        while not condition(lines := self.lines()):
            if time.monotonic() > end or self.process.poll() is not None:
                raise TimeoutError("\n".join(lines))
            time.sleep(0.05)
        return lines

    def click(self, browser, label):
        """Clicks, and waits until the session has told something new."""
        before = len(self.lines())
        browser.click(label)
        told = self.wait_for(lambda lines: len(lines) > before)[-1]
        time.sleep(SETTLE_S)
        return told


@pytest.mark.slow
def test_a_browser_teaches_and_what_was_not_saved_is_kept(tmp_path):
    file = tmp_path / "taught.yaml"
    with Command(file, tmp_path / "log.txt") as command:
        lines = command.wait_for(lambda lines: lines and "over the object" in lines[-1])
        (page,) = (line.split()[2] for line in lines if line.startswith("teach at"))
        with Browser(page) as browser:
            browser.click("Open Controls")
            for label in ("set key point", "up", "up", "set key point", "save"):
                command.click(browser, label)
            command.click(browser, "set key point")
            told = command.click(browser, "delete key point")
            assert "key point 2 of 2" in told
            browser.press("g", "KeyG")  # The fingers' slider; it stands before the buttons.
            time.sleep(SETTLE_S)
            command.click(browser, "set key point")
            browser.click("stop")
            assert command.process.wait(timeout=LIMIT_S) == 0
        assert "unsaved" in command.lines()[-1]
    saved = load_key_points(file).key_points
    assert [point.position_m[2] for point in saved] == [0.0, 0.01]
    unsaved = load_key_points(file.with_suffix(UNSAVED)).key_points
    assert [point.fingers for point in unsaved] == [0.0, 0.0, 0.02]
