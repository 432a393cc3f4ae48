import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Integrator
from typer.testing import CliRunner

from vh_drake.cli import app
from vh_drake.errors import BadInput, VhDrakeError
from vh_drake.scenes import drawing
from vh_drake.scenes.drawing import draw_diagram


@pytest.fixture
def diagram():
    """Two integrators within a diagram, one after the other."""
    inner = DiagramBuilder()
    first = inner.AddNamedSystem("velocity", Integrator(1))
    second = inner.AddNamedSystem("position", Integrator(1))
    inner.Connect(first.get_output_port(), second.get_input_port())
    outer = DiagramBuilder()
    outer.AddNamedSystem("inside", inner.Build())
    return outer.Build()


def texts(path):
    return {
        element.text.strip() for element in ET.parse(path).iter() if element.text and element.text
    }


def test_svg_names_every_system(diagram, tmp_path):
    words = " ".join(texts(draw_diagram(diagram, tmp_path / "d.svg")))
    assert "velocity" in words
    assert "position" in words


def test_less_depth_leaves_the_inside_closed(diagram, tmp_path):
    words = " ".join(texts(draw_diagram(diagram, tmp_path / "d.svg", depth=1)))
    assert "inside" in words
    assert "velocity" not in words


@pytest.mark.parametrize(("kind", "magic"), [("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_the_ending_names_the_format(diagram, tmp_path, kind, magic):
    assert draw_diagram(diagram, tmp_path / f"d.{kind}").read_bytes().startswith(magic)


def test_missing_folders_are_made(diagram, tmp_path):
    assert draw_diagram(diagram, tmp_path / "a" / "b" / "d.dot").is_file()


def test_unknown_ending_names_the_choices(diagram, tmp_path):
    with pytest.raises(BadInput, match=r"\.svg, \.png, \.pdf, \.dot"):
        draw_diagram(diagram, tmp_path / "d.jpg")


def test_without_graphviz_the_error_names_the_remedy(diagram, tmp_path, monkeypatch):
    monkeypatch.setattr(drawing.shutil, "which", lambda name: None)
    with pytest.raises(VhDrakeError, match="install graphviz"):
        draw_diagram(diagram, tmp_path / "d.svg")
    assert draw_diagram(diagram, tmp_path / "d.dot").read_text().startswith("digraph")
    assert not (tmp_path / "d.svg").exists()


def test_the_command_draws_the_whole_diagram(tmp_path):
    done = CliRunner().invoke(app, ["diagram", "--out", str(tmp_path / "d.dot")])
    assert done.exit_code == 0, done.output
    source = (tmp_path / "d.dot").read_text()
    assert all(name in source for name in ("GpisEstimator", "Behaviour", "TendonHand"))
