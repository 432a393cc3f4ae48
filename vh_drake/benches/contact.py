"""`bench contact`: how soon and how well the wrist feels a touch, at three speeds."""

import dataclasses as dc

import numpy as np
from pydrake.geometry import ContactSurface
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from vh_drake.batch import run_tasks
from vh_drake.catalog import Options
from vh_drake.geometry.meshes import TriMesh
from vh_drake.hand.description import load_hand
from vh_drake.hand.model import read_hand_model
from vh_drake.hand.shipped import hand_file
from vh_drake.objects.lathe import box, cylinder, sphere
from vh_drake.objects.model import ObjectModel, make_object
from vh_drake.objects.primitives import BoxShape, CylinderShape, SphereShape
from vh_drake.reports import Report, Row
from vh_drake.scenes.sliding_hand import WAIT_S, SlidingHand, make_sliding_hand
from vh_drake.sensing.ft_contact import FtContactSettings
from vh_drake.types import Array, ContactSet

SPEEDS_M_S = (0.05, 0.10, 0.20)
MASSES_KG = (0.03, 1.0)  # drawn evenly in the logarithm
_GAP_M = 0.04
_BEYOND_S = 0.6  # after the hand should have met the object
_SETTLED_S = 0.12  # after detection
_WATCH_S = 0.004
_BEARING_SHARE = 0.25  # of the whole force: a patch that bears less is not where the hand touches
_HEAVY_KG = 0.15


def run(options: Options) -> Report:
    """Simulated approaches to boxes, cylinders and balls of 30 g to 1 kg.

    Raises:
        BadInput: an option is unusable.
    """
    runs = options.runs or 200
    tasks = {
        f"{speed:g} m/s, {i}": {"speed_m_s": speed, "seed": options.seed * 100_000 + i}
        for speed in SPEEDS_M_S
        for i in range(runs)
    }
    settings = {"runs": runs, "seed": options.seed, "speeds_m_s": list(SPEEDS_M_S)}
    rows = run_tasks(
        approach_row,
        tasks,
        settings=settings,
        journal=options.out / "contact.journal",
        workers=options.workers,
        title="touch",
    )
    summary = summary_at(rows, SPEEDS_M_S[0], "")
    for speed in SPEEDS_M_S[1:]:
        summary |= summary_at(rows, speed, f"_at_{round(100 * speed)}_cm_s")
    return Report("contact", settings, summary, {}, rows)


def summary_at(rows: list[Row], speed_m_s: float, suffix: str) -> Row:
    """Means over the approaches at one speed; detection also of heavy objects alone."""
    own = [row for row in rows if row["speed_m_s"] == speed_m_s]
    found = [row for row in own if row["detected"]]
    heavy = [row["detected"] for row in own if row["mass_kg"] > _HEAVY_KG]
    summary: Row = {
        "detected_share": _mean([row["detected"] for row in own]),
        "detected_share_over_150_g": _mean(heavy),
        "false_alarms": sum(row["false_alarm"] for row in own),
    }
    for key in (
        "delay_ms",
        "force_at_detection_n",
        "force_overshoot_n",
        "position_error_mm",
        "normal_error_deg",
        "displacement_mm",
    ):
        summary[key] = _mean([row[key] for row in found])
        summary[f"{key}_95_percent"] = _quantile([row[key] for row in found])
    return {f"{key}{suffix}": value for key, value in summary.items()}


def _mean(values: list[float]) -> float | None:
    return round(float(np.mean(values)), 4) if values else None


def _quantile(values: list[float]) -> float | None:
    return round(float(np.quantile(values, 0.95)), 4) if values else None


def approach_row(task: dict[str, float]) -> Row:
    """One approach: what was felt, and what was true."""
    seed, speed = int(task["seed"]), task["speed_m_s"]
    rng = np.random.default_rng([seed, round(1000 * speed)])
    model, X_TO, pad_height_m = draw_scene(rng)
    hand = read_hand_model(load_hand(hand_file("")))
    scene = make_sliding_hand(
        hand, model, X_TO, pad_height_m=pad_height_m, speed_m_s=speed, seed=seed
    )
    watch = _observe(scene, WAIT_S + _GAP_M / speed + _BEYOND_S)
    return {
        "speed_m_s": speed,
        "seed": seed,
        "object": model.name,
        "mass_kg": round(model.mass_kg, 4),
        **watch.row(speed),
    }


def draw_scene(rng: np.random.Generator) -> tuple[ObjectModel, RigidTransform, float]:
    """An object, its pose with the near side _GAP_M before the pad, and the pad's height."""
    low, high = np.log(MASSES_KG)
    model = _draw_object(str(rng.choice(["box", "cylinder", "ball"])), rng, low, high)
    R = RollPitchYaw(0.0, 0.0, rng.uniform(-0.5, 0.5) if model.name == "box" else 0.0)
    points = model.mesh.vertices @ R.ToRotationMatrix().matrix().T
    height = float(points[:, 2].max())
    shift_y = rng.uniform(-0.01, 0.01)
    X_TO = RigidTransform(R, [_GAP_M - points[:, 0].min(), shift_y, -points[:, 2].min()])
    return model, X_TO, float(np.clip(rng.uniform(0.4, 0.7) * height, 0.025, height - 0.012))


def _draw_object(name: str, rng: np.random.Generator, low: float, high: float) -> ObjectModel:
    mass = float(np.exp(rng.uniform(low, high)))
    if name == "box":
        x, y, z = (float(side) for side in rng.uniform([0.05, 0.06, 0.05], [0.1, 0.16, 0.18]))
        mesh: TriMesh = box((x, y, z))
        return make_object(name, mesh, mass, primitive=BoxShape((x, y, z), (0.0, 0.0, z / 2)))
    if name == "cylinder":
        r, z = float(rng.uniform(0.03, 0.05)), float(rng.uniform(0.05, 0.18))
        shape = CylinderShape(r, z, (0.0, 0.0, z / 2))
        return make_object(name, cylinder(r, z), mass, primitive=shape)
    r = float(rng.uniform(0.03, 0.06))
    return make_object(name, sphere(r), mass, primitive=SphereShape(r, (0.0, 0.0, r)))


@dc.dataclass(frozen=True)
class Patch:
    """Where a part of the hand presses on the object."""

    force_W: Array  # (3,) on the hand [N]
    p_WC: Array  # (3,) centroid [m]
    n_WC: Array  # (3,) the object's outward unit normal, mean over the patch


@dc.dataclass
class Watch:
    """What an observer notes of one approach."""

    touched_s: float | None = None  # first true contact
    detected_s: float | None = None
    force_n: float = 0.0  # true force at detection
    most_force_n: float = 0.0
    patches: list[Patch] = dc.field(default_factory=list)  # when the force was greatest
    position_error_m: float = np.nan
    normal_error_rad: float = np.nan
    displacement_m: float = np.nan

    def note(self, patches: list[Patch], now_s: float) -> float:
        """Takes down what presses now; the whole force [N]."""
        force = float(np.linalg.norm(sum(patch.force_W for patch in patches)))
        if patches and self.touched_s is None:
            self.touched_s = now_s
        if force > self.most_force_n:
            self.most_force_n, self.patches = force, patches
        return force

    def compare(self, felt: ContactSet) -> None:
        """Errors of a felt contact: against the nearest patch that bears a part of the force.

        A slight object leaves the finger and meets it again, so the moment of the greatest
        force counts, not the last. Two fingers may touch at once: either place is true.
        """
        bearing = [
            patch
            for patch in self.patches
            if np.linalg.norm(patch.force_W) >= _BEARING_SHARE * self.most_force_n
        ]
        gaps = [float(np.linalg.norm(felt.p_WC[0] - patch.p_WC)) for patch in bearing]
        cosine = felt.n_WC[0] @ bearing[int(np.argmin(gaps))].n_WC
        self.position_error_m = min(gaps)
        self.normal_error_rad = float(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def row(self, speed_m_s: float) -> Row:
        """The notes as numbers that JSON holds."""
        touched, detected = self.touched_s, self.detected_s
        good = touched is not None and detected is not None and detected >= touched
        settings = FtContactSettings()
        fast = speed_m_s > settings.fast_speed_m_s
        threshold = settings.fast_threshold_n if fast else settings.threshold_n
        row: Row = {
            "touched": touched is not None,
            "detected": good,
            "false_alarm": detected is not None and not good,
        }
        if not good or touched is None or detected is None:
            return row
        return row | {
            "delay_ms": round(1000 * (detected - touched), 3),
            "force_at_detection_n": round(self.force_n, 4),
            "force_overshoot_n": round(self.most_force_n - threshold, 4),
            "position_error_mm": round(1000 * self.position_error_m, 3),
            "normal_error_deg": round(float(np.rad2deg(self.normal_error_rad)), 3),
            "displacement_mm": round(1000 * self.displacement_m, 3),
        }


def _observe(scene: SlidingHand, until_s: float) -> Watch:
    simulator = Simulator(scene.diagram)
    root = simulator.get_mutable_context()
    plant_context = scene.plant.GetMyContextFromRoot(root)
    estimator_context = scene.estimator.GetMyContextFromRoot(root)
    X_WO = scene.plant.EvalBodyPoseInWorld(plant_context, scene.object)
    start, watch = X_WO.translation().copy(), Watch()
    while root.get_time() < until_s:
        simulator.AdvanceTo(root.get_time() + _WATCH_S)
        now = root.get_time()
        force = watch.note(true_patches(scene, plant_context), now)
        if watch.detected_s is None and scene.estimator.GetOutputPort("contact").Eval(
            estimator_context
        ):
            watch.detected_s, watch.force_n = now, force
            until_s = now + _SETTLED_S
    if watch.detected_s is None or watch.touched_s is None:
        return watch
    watch.compare(scene.estimator.GetOutputPort("contact_point").Eval(estimator_context))
    X_WO = scene.plant.EvalBodyPoseInWorld(plant_context, scene.object)
    watch.displacement_m = float(np.linalg.norm(X_WO.translation() - start))
    return watch


def true_patches(scene: SlidingHand, context: Context) -> list[Patch]:
    """All places where hand and object press on each other."""
    results = scene.plant.get_contact_results_output_port().Eval(context)
    hand, found = scene.base.model_instance(), []
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        bodies = [_body(scene, context, g) for g in (surface.id_M(), surface.id_N())]
        if scene.object not in bodies or all(b.model_instance() != hand for b in bodies):
            continue
        # Drake's normals point out of N, and the force is that on M's body.
        out = 1.0 if bodies[1] is scene.object else -1.0
        force = out * info.F_Ac_W().translational()
        found.append(Patch(force, np.array(surface.centroid()), out * _mean_normal(surface)))
    return found


def _mean_normal(surface: ContactSurface) -> Array:
    """Mean of a contact surface's unit normals (3,), weighted by area, of unit length."""
    faces = range(surface.num_faces())
    total = sum(surface.area(face) * surface.face_normal(face) for face in faces)
    normal: Array = total / np.linalg.norm(total)
    return normal


def _body(scene: SlidingHand, context: Context, geometry: object) -> RigidBody:
    query = scene.plant.get_geometry_query_input_port().Eval(context)
    return scene.plant.GetBodyFromFrameId(query.inspector().GetFrameId(geometry))
