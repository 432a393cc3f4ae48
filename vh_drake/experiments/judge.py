"""What really happened: ground truth that the deciding part never sees."""

import dataclasses as dc

import numpy as np
import trimesh.triangles
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context

from vh_drake.geometry.meshes import TriMesh
from vh_drake.geometry.sampling import sample_surface
from vh_drake.geometry.signed_distance import distance_to_surface
from vh_drake.grasping.story import TouchRecord
from vh_drake.objects.model import ObjectModel
from vh_drake.scenes.station import Station
from vh_drake.types import Array, Surface

_SAMPLES = 3000


@dc.dataclass(frozen=True, eq=False)
class TrueTouch:
    """Where the hand touched the object."""

    p_WC: Array  # (3,) where it pressed most [m]
    p_OC: Array  # (3,) the same in the object's frame
    X_WO: RigidTransform  # the object's pose just then


class Judge:
    """Reads the simulated world of a diagram that holds a station.

    Args:
        station: the simulated robot.
        model: the object.
        root_context: of the whole diagram, the one that the simulator advances.
    """

    def __init__(self, station: Station, model: ObjectModel, root_context: Context) -> None:
        self._plant = station.world.plant
        self._world = station.world
        self._model = model
        self._context = self._plant.GetMyContextFromRoot(root_context)
        self._hand = set(self._plant.GetBodyIndices(station.world.hand))

    def object_pose(self) -> RigidTransform:
        """X_WO now."""
        return self._plant.EvalBodyPoseInWorld(self._context, self._world.object)

    def object_in_hand(self) -> RigidTransform:
        """X_HO now."""
        base = self._plant.GetBodyByName(self._world.description.base, self._world.hand)
        return self._plant.EvalBodyPoseInWorld(self._context, base).inverse() @ self.object_pose()

    def lowest_point(self) -> float:
        """Height of the object's lowest point over the floor [m]."""
        X_WO = self.object_pose()
        lowest: float = (self._model.mesh.vertices @ X_WO.rotation().matrix()[2]).min()
        return lowest + float(X_WO.translation()[2])

    def touch(self) -> TrueTouch | None:
        """The contact between hand and object now, None where there is none."""
        pressed = self._contacts()
        if not pressed:
            return None
        p_WC = max(pressed, key=lambda contact: contact[0])[1]
        X_WO = self.object_pose()
        return TrueTouch(p_WC, X_WO.inverse() @ p_WC, X_WO)

    def _contacts(self) -> list[tuple[float, Array]]:
        """Forces [N] and places (3,) [m] at which hand and object press on each other."""
        results = self._plant.get_contact_results_output_port().Eval(self._context)
        points = []
        for i in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(i)
            if self._is_touch(info.bodyA_index(), info.bodyB_index()):
                force = float(np.linalg.norm(info.contact_force()))
                points.append((force, np.array(info.contact_point())))
        for i in range(results.num_hydroelastic_contacts()):
            patch = results.hydroelastic_contact_info(i)
            surface = patch.contact_surface()
            bodies = [self._body_of(surface.id_M()), self._body_of(surface.id_N())]
            if self._is_touch(*bodies):
                force = float(np.linalg.norm(patch.F_Ac_W().translational()))
                points.append((force, np.array(surface.centroid())))
        return points

    def _body_of(self, geometry_id: object) -> BodyIndex:
        query = self._plant.get_geometry_query_input_port().Eval(self._context)
        frame = query.inspector().GetFrameId(geometry_id)
        return self._plant.GetBodyFromFrameId(frame).index()

    def _is_touch(self, a: BodyIndex, b: BodyIndex) -> bool:
        item = self._world.object.index()
        return (a == item and b in self._hand) or (b == item and a in self._hand)


def surface_error_mm(surface: Surface, mesh: TriMesh, X_WO: RigidTransform) -> float:
    """Symmetric mean distance between an estimate and the truth [mm]."""
    truth = mesh.transformed(X_WO.GetAsMatrix4())
    estimate = TriMesh(surface.vertices, surface.faces)
    there = distance_to_surface(truth, sample_surface(estimate, _SAMPLES, seed=0)[0])
    back = distance_to_surface(estimate, sample_surface(truth, _SAMPLES, seed=0)[0])
    return float(500.0 * (there.mean() + back.mean()))


def touch_report(
    record: TouchRecord,
    truth: TrueTouch | None,
    mesh: TriMesh,
    p_WCamera: Array,
    displacement_mm: float,
) -> dict[str, object]:
    """A touch in numbers: prediction, sensation and truth."""
    report: dict[str, object] = {
        "felt": record.felt,
        "time_s": round(record.time_s, 3),
        "predicted_position_m": rounded(record.plan.p_WT),
        "predicted_normal": rounded(record.plan.n_WT),
        "rating": float(record.plan.rating),
        "object_displacement_mm": round(displacement_mm, 3),
    }
    if record.felt:
        report |= {
            "felt_position_m": rounded(record.p_WC),
            "felt_normal": rounded(record.n_WC),
            "view_shift_m": rounded(record.view_shift),
        }
    if truth is not None:
        p_OS, n_OS = nearest_surface_point(mesh, truth.p_OC)
        p_WS, n_WS = truth.X_WO @ p_OS, truth.X_WO.rotation() @ n_OS
        to_camera = (p_WCamera - p_WS) / np.linalg.norm(p_WCamera - p_WS)
        report |= {
            "actual_position_m": rounded(p_WS),
            "actual_normal": rounded(n_WS),
            "prediction_error_mm": _millimetres(record.plan.p_WT, p_WS),
            "prediction_normal_error_deg": _degrees(record.plan.n_WT, n_WS),
            "cosine_to_camera": round(float(n_WS @ to_camera), 4),
            "faces_away_from_camera": bool(n_WS @ to_camera < 0),
        }
        if record.felt:
            report |= {
                "felt_error_mm": _millimetres(record.p_WC, p_WS),
                "felt_normal_error_deg": _degrees(record.n_WC, n_WS),
            }
    return report


def nearest_surface_point(mesh: TriMesh, p_O: Array) -> tuple[Array, Array]:
    """The point of a mesh next to p_O (3,), and the outward normal of its triangle."""
    corners = mesh.triangles
    p = closest_on_triangles(corners, p_O)
    best = int(np.linalg.norm(p - p_O, axis=1).argmin())
    return p[best], mesh.face_normals[best]


def closest_on_triangles(corners: Array, point: Array) -> Array:
    """The point of each triangle (n, 3, 3) next to a point (3,): (n, 3)."""
    n = len(corners)
    closest: Array = trimesh.triangles.closest_point(corners, np.tile(point, (n, 1)))
    return closest


def rounded(vector: Array, digits: int = 5) -> list[float]:
    """A vector as plain numbers."""
    return [round(float(x), digits) for x in np.asarray(vector).ravel()]


def _millimetres(a: Array, b: Array) -> float:
    return round(1000.0 * float(np.linalg.norm(np.asarray(a) - b)), 3)


def _degrees(a: Array, b: Array) -> float:
    return round(float(np.rad2deg(np.arccos(np.clip(np.asarray(a) @ b, -1.0, 1.0)))), 2)
