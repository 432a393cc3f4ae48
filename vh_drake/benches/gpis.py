"""Surface estimation in time and agreement: ours, GPyTorch and scikit-learn.

All run on one thread in float64 and are measured by processor time, the best of several calls. A
peer's potential is measured on a part of the grid and multiplied, since it costs the same for
each node.
"""

import math
import time

import numpy as np

from vh_drake.benches.gpis_peers import GPyTorchSurface, ScikitSurface, require
from vh_drake.benches.timing import best_ms
from vh_drake.catalog import Options
from vh_drake.exploration.ratings import IgefSettings, igef
from vh_drake.exploration.trajectory import approach_curves, arc_length
from vh_drake.gpis.contact_surface import ContactNoise, ContactSurface
from vh_drake.gpis.following import follow_surface
from vh_drake.gpis.inside_outside import InsideOutside, inside_outside_observations
from vh_drake.gpis.kernels import Kernel, SquaredExponential, ThinPlate
from vh_drake.gpis.meshing import closed_mesh
from vh_drake.gpis.observations import Observations, surface_observations
from vh_drake.gpis.posterior import Posterior, fit
from vh_drake.reports import Report, Row
from vh_drake.types import Array, ScalarGrid, TouchPlan

CONTACTS = (20, 50, 100, 200, 400)
TARGET = 50  # contacts at which the summary is taken
NODES = 50  # a side of the grid
QUERIES = 2000  # points whose variance is asked
RADIUS_M = 0.05
SPACING_M = 0.005  # of the followed surface
EXPONENTIAL = SquaredExponential(0.06, 0.03)
PLATE_NAME = "ours, thin plate"
PLATE = ThinPlate(0.5, 0.5 / math.sqrt(6.0))
NOISE = ContactNoise(0.001, 0.1)
_MEAN_PART, _PREDICT_PART = 5000, 200  # nodes on which GPyTorch is measured


def run(options: Options) -> Report:
    """Measure all libraries for growing numbers of contacts."""
    from threadpoolctl import threadpool_limits

    require("torch").set_num_threads(1)
    rows: list[Row] = []
    with threadpool_limits(1):
        for count in CONTACTS:
            rows += rows_for(count, options.seed)
        summary = _summary(rows) | {
            "max_difference": difference_from_gpytorch(options.seed),
            "max_difference_from_scikit_learn": difference_from_scikit_learn(options.seed),
            "touch_step_ms": touch_step_ms(options.seed),
        }
    settings = {
        "seed": options.seed,
        "threads": 1,
        "grid_nodes": NODES**3,
        "variance_points": QUERIES,
        "kernel_length_m": EXPONENTIAL.length_m,
        "summary_at_contacts": TARGET,
    }
    return Report("gpis", settings, summary, rows=rows)


def contacts(count: int, seed: int) -> tuple[Array, Array]:
    """Evenly distributed random contacts (count, 3) and normals on a ball."""
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    return RADIUS_M * n, n


def with_normals(count: int, seed: int) -> Observations:
    """What the squared exponential and GPyTorch are fitted to."""
    return surface_observations(
        *contacts(count, seed), value_std_m=NOISE.position_std_m, gradient_std=NOISE.normal_std
    )


def without_normals(count: int, seed: int) -> Observations:
    """What scikit-learn is fitted to: contacts, an inside and twelve outside points."""
    settings = InsideOutside(contact_std_m=NOISE.position_std_m, added_std_m=NOISE.position_std_m)
    return inside_outside_observations(contacts(count, seed)[0], settings)


def axis() -> Array:
    """Coordinates of the grid's nodes along each axis (NODES,) [m]."""
    return np.linspace(-1.2 * RADIUS_M, 1.2 * RADIUS_M, NODES)


def nodes() -> Array:
    """All nodes of the grid (NODES³, 3) [m]."""
    return np.stack(np.meshgrid(*[axis()] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def rows_for(count: int, seed: int) -> list[Row]:
    """Times of every library for one number of contacts [ms]."""
    seen, values = with_normals(count, seed), without_normals(count, seed)
    return [
        _row("ours, squared exponential", count, times_of_ours(EXPONENTIAL, seen)),
        _row(PLATE_NAME, count, times_of_ours(PLATE, seen)),
        _row("ours, values alone", count, times_of_ours(EXPONENTIAL, values)),
        _row("gpytorch", count, times_of_gpytorch(seen)),
        _row("scikit-learn, values alone", count, times_of_scikit_learn(values)),
    ]


def _row(library: str, count: int, times: dict[str, float]) -> Row:
    return {"library": library, "contacts": count, **times}


def times_of_ours(kernel: Kernel, seen: Observations) -> dict[str, float]:
    """Fit, append, grid, mesh and variance of this package [ms]."""
    points, on_surface = _query_points(), seen.p[seen.value == 0.0]
    posterior = fit(kernel, seen)
    return {
        "fit_ms": best_ms(lambda: fit(kernel, seen), repeats=30),
        "append_ms": _append_ms(posterior),
        "grid_ms": best_ms(lambda: posterior.mean_on_grid(axis(), axis(), axis()), repeats=30),
        "mesh_ms": best_ms(
            lambda: follow_surface(posterior, on_surface, spacing_m=SPACING_M), repeats=30
        ),
        "variance_ms": best_ms(lambda: posterior.variance(points), repeats=30),
    }


def _append_ms(posterior: Posterior) -> float:
    """The least processor time of appending a contact, in a chain of ten [ms]."""
    p, n = contacts(11, seed=1)
    noise = {"value_std_m": NOISE.position_std_m, "gradient_std": NOISE.normal_std}
    new = [surface_observations(p[i : i + 1], n[i : i + 1], **noise) for i in range(len(p))]
    grown, times = posterior.append(new[0]), []  # the first makes room for those that follow
    for one in new[1:]:
        start = time.process_time()
        grown = grown.append(one)
        times.append(1e3 * (time.process_time() - start))
    return min(times)


def times_of_gpytorch(seen: Observations) -> dict[str, float]:
    """The same of GPyTorch [ms]."""
    peer, everywhere, few = GPyTorchSurface(EXPONENTIAL, seen), nodes(), _query_points()[:200]
    part, small = everywhere[:_MEAN_PART], everywhere[:_PREDICT_PART]
    grid = best_ms(lambda: peer.mean(part), repeats=3) * len(everywhere) / len(part)
    predict = best_ms(lambda: peer.predicted_mean(small), repeats=3) * len(everywhere) / len(small)
    refit = best_ms(lambda: GPyTorchSurface(EXPONENTIAL, seen), repeats=3)
    return {
        "fit_ms": refit,
        "append_ms": refit,  # it can't append to a process on gradients
        "grid_ms": grid,
        "mesh_ms": grid + _marching_ms(seen),
        "variance_ms": best_ms(lambda: peer.variance(few), repeats=2) * QUERIES / len(few),
        "predicted_grid_ms": predict,
    }


def times_of_scikit_learn(values: Observations) -> dict[str, float]:
    """The same of scikit-learn [ms]."""
    peer, everywhere, points = ScikitSurface(EXPONENTIAL, values), nodes(), _query_points()
    grid = best_ms(lambda: peer.mean(everywhere), repeats=3)
    refit = best_ms(lambda: ScikitSurface(EXPONENTIAL, values), repeats=5)
    return {
        "fit_ms": refit,
        "append_ms": refit,
        "grid_ms": grid,
        "mesh_ms": grid + _marching_ms(values),
        "variance_ms": best_ms(lambda: peer.variance(points), repeats=3),
    }


def _query_points() -> Array:
    return nodes()[:: NODES**3 // QUERIES][:QUERIES]


def _marching_ms(seen: Observations) -> float:
    """Marching cubes on a filled grid, which the peers need for a mesh [ms]."""
    values = fit(EXPONENTIAL, seen).mean_on_grid(axis(), axis(), axis())
    grid = ScalarGrid(np.full(3, axis()[0]), axis()[1] - axis()[0], values)
    return best_ms(lambda: closed_mesh(grid, seen.p[seen.value == 0.0]), repeats=5)


def difference_from_gpytorch(seed: int) -> float:
    """Largest difference of the potential on every 25th node, over its largest value."""
    seen = with_normals(TARGET, seed)
    ours = fit(EXPONENTIAL, seen).mean_on_grid(axis(), axis(), axis()).ravel()
    theirs = GPyTorchSurface(EXPONENTIAL, seen).mean(nodes()[::25])
    return float(np.abs(ours[::25] - theirs).max() / np.abs(ours).max())


def difference_from_scikit_learn(seed: int) -> float:
    """The same for values alone, on all nodes."""
    seen = without_normals(TARGET, seed)
    ours = fit(EXPONENTIAL, seen).mean_on_grid(axis(), axis(), axis()).ravel()
    return float(
        np.abs(ours - ScikitSurface(EXPONENTIAL, seen).mean(nodes())).max() / np.abs(ours).max()
    )


def touch_step_ms(seed: int) -> float:
    """One whole touch step at 50 contacts: append, surface, rating, choice, trajectory [ms]."""
    surface, (p_WC, n_WC) = surface_before_touch(seed), last_touch(seed)
    return best_ms(lambda: touch_step(surface, p_WC, n_WC), repeats=40)


def surface_before_touch(seed: int) -> ContactSurface:
    """All contacts but the last."""
    p, n = contacts(TARGET, seed)
    surface = ContactSurface.of(p[:-2], n[:-2], kernel=PLATE, noise=NOISE)
    return surface.append(p[-2], n[-2])


def last_touch(seed: int) -> tuple[Array, Array]:
    """The last contact (3,) and its normal (3,)."""
    p, n = contacts(TARGET, seed)
    return p[-1], n[-1]


def touch_step(surface: ContactSurface, p_WC: Array, n_WC: Array) -> TouchPlan:
    """Take in a contact and choose the next."""
    surface = surface.append(p_WC, n_WC)
    sheet = surface.follow(spacing_m=SPACING_M)
    curves = approach_curves(p_WC, n_WC, sheet.vertices, sheet.normals)
    rating = igef(
        sheet.vertices, sheet.normals, surface.p_WC, arc_length(curves), -n_WC, IgefSettings()
    ).product
    best = int(np.argmax(rating))
    return TouchPlan(sheet.vertices[best], sheet.normals[best], curves[best], float(rating[best]))


def _summary(rows: list[Row]) -> dict[str, float]:
    """Times at the target's number of contacts, and how they compare."""
    at = {row["library"]: row for row in rows if row["contacts"] == TARGET}
    ours, plate = at["ours, squared exponential"], at[PLATE_NAME]
    peer, scikit, values = (
        at["gpytorch"],
        at["scikit-learn, values alone"],
        at["ours, values alone"],
    )
    summary = {
        "grid_speedup_over_gpytorch": peer["grid_ms"] / ours["grid_ms"],
        "grid_speedup_over_gpytorch_prediction": peer["predicted_grid_ms"] / ours["grid_ms"],
        "append_ms": plate["append_ms"],
        "append_growth_exponent": append_growth(rows),
    }
    for what in ("fit", "append", "mesh", "variance"):
        summary[f"{what}_speedup_over_gpytorch"] = peer[f"{what}_ms"] / ours[f"{what}_ms"]
    for what in ("fit", "append", "grid", "mesh", "variance"):
        summary[f"{what}_speedup_over_scikit_learn"] = scikit[f"{what}_ms"] / values[f"{what}_ms"]
    return summary


def append_growth(rows: list[Row]) -> float:
    """Exponent of the time of an append between 100 and 400 contacts; 2 is O(N²)."""
    time_ms = {row["contacts"]: row["append_ms"] for row in rows if row["library"] == PLATE_NAME}
    return math.log(time_ms[400] / time_ms[100]) / math.log(4.0)
