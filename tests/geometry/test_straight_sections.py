import numpy as np
import pytest

from vh_drake.geometry.straight_sections import straight_sections


def test_a_straight_line_is_one_section():
    p = np.outer(np.linspace(0, 0.1, 21), [0.6, 0.0, 0.8])
    (section,) = straight_sections(p, tolerance_m=0.003, least_length_m=0.02)
    assert (section.first, section.last) == (0, 20)
    np.testing.assert_allclose(section.direction, [0.6, 0, 0.8])
    assert section.length == pytest.approx(0.1)


def test_an_angle_is_cut_at_its_corner():
    arm = np.outer(np.linspace(0, 0.05, 11), [1.0, 0, 0])
    p = np.vstack([arm, arm[-1] + np.outer(np.linspace(0.005, 0.05, 10), [0, 1.0, 0])])
    one, other = straight_sections(p, tolerance_m=0.003, least_length_m=0.02)
    assert (one.first, one.last, other.first, other.last) == (0, 10, 10, 20)
    np.testing.assert_allclose(one.direction @ other.direction, 0, atol=1e-12)


@pytest.mark.parametrize("tolerance_m", [0.002, 0.005, 0.01])
def test_no_node_of_an_arc_is_farther_from_its_section_than_the_tolerance(tolerance_m):
    angle = np.linspace(0, np.pi, 60)
    p = 0.06 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    sections = straight_sections(p, tolerance_m=tolerance_m, least_length_m=0.0)
    assert [s.first for s in sections[1:]] == [s.last for s in sections[:-1]]
    for section in sections:
        offset = p[section.first : section.last + 1] - p[section.first]
        away = offset - np.outer(offset @ section.direction, section.direction)
        assert np.linalg.norm(away, axis=1).max() <= tolerance_m + 1e-12


def test_short_sections_are_left_out_unless_all_are_short():
    corner = np.array([[0, 0, 0], [0.05, 0, 0], [0.05, 0.01, 0]])
    assert len(straight_sections(corner, tolerance_m=0.002, least_length_m=0.02)) == 1
    assert len(straight_sections(corner, tolerance_m=0.002, least_length_m=0.2)) == 1
    assert straight_sections(corner[:1], tolerance_m=0.002, least_length_m=0.0) == ()


def test_a_closed_line_has_sections_too():
    angle = np.linspace(0, 2 * np.pi, 60)
    p = 0.06 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    p[-1] = p[0]
    sections = straight_sections(p, tolerance_m=0.005, least_length_m=0.01)
    assert len(sections) >= 4
