"""Compiled arithmetic of the arm: kinematics, the three Cartesian controllers, their rollout.

But for rotations it stands in one file, since numba's cache notices changes of a kernel's own file
only. The modules beside it say what each part means and check what comes in.
"""

import numpy as np
from numba import njit

from vh_drake.geometry.compiling import bare_njit
from vh_drake.geometry.rotations import rotation_vector
from vh_drake.types import Array

SINGULAR_VALUE_FLOOR = 1e-9  # directions below count as not reachable at all
FASTEST = 1e3  # of spatial velocities [rad/s, m/s]; no joint gets anywhere near


@njit(cache=True)
def cross(a: Array, b: Array) -> Array:
    """Vector product of (3,) arrays."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@bare_njit
def carry(axes: Array, points: Array, q: Array, motions: Array) -> None:
    """How positions q (n,) move what hangs on each joint from where it is at q = 0.

    Joint i turns about axes[i] (n, 3) through points[i] (n, 3). motions (n + 1, 3, 4) is filled:
    a rotation each and, in the last column, a translation; the first one is none, that of what
    hangs on joint i is motions[i + 1].
    """
    for k in range(3):
        for i in range(4):
            motions[0, k, i] = 1.0 if i == k else 0.0
    for i in range(len(q)):
        x, y, z = axes[i, 0], axes[i, 1], axes[i, 2]
        s, c = np.sin(q[i]), np.cos(q[i])
        d = 1.0 - c
        before, after = motions[i], motions[i + 1]
        for k in range(3):
            u, v, w = before[k, 0], before[k, 1], before[k, 2]
            after[k, 0] = u * (c + x * x * d) + v * (y * x * d + z * s) + w * (z * x * d - y * s)
            after[k, 1] = u * (x * y * d - z * s) + v * (c + y * y * d) + w * (z * y * d + x * s)
            after[k, 2] = u * (x * z * d + y * s) + v * (y * z * d - x * s) + w * (c + z * z * d)
            after[k, 3] = before[k, 3]
            for m in range(3):
                after[k, 3] += (before[k, m] - after[k, m]) * points[i, m]


@bare_njit
def moved(motion: Array, x: Array, share: float, k: int) -> float:
    """Coordinate k of R x + share p, for a motion (3, 4) and x (3,)."""
    turned: float = motion[k, 0] * x[0] + motion[k, 1] * x[1] + motion[k, 2] * x[2]
    return turned + share * motion[k, 3]


@njit(cache=True)
def forward(axes: Array, points: Array, X_WH0: Array, q: Array) -> tuple[Array, Array]:
    """Hand pose (4, 4) and geometric Jacobian (6, n) from world screw axes at q = 0.

    Joint i turns about axes[i] (n, 3) through points[i] (n, 3); X_WH0 is the pose at q = 0.
    """
    n = len(q)
    motions = np.empty((n + 1, 3, 4))
    carry(axes, points, q, motions)
    X, J, lever = np.eye(4), np.empty((6, n)), np.empty(3)
    for k in range(3):
        for i in range(4):
            X[k, i] = moved(motions[n], X_WH0[:3, i], X_WH0[3, i], k)
    for i in range(n):
        for k in range(3):
            J[k, i] = moved(motions[i], axes[i], 0.0, k)
            lever[k] = X[k, 3] - moved(motions[i], points[i], 1.0, k)
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            J[3 + k, i] = J[a, i] * lever[b] - J[b, i] * lever[a]
    return X, J


@njit(cache=True)
def spatial_acceleration(
    axes: Array, points: Array, X_WH0: Array, q: Array, velocity: Array, acceleration: Array
) -> Array:
    """Rates (6,) of the hand's angular and linear velocity in W, of its origin.

    Velocities (n,) [rad/s] and accelerations (n,) [rad/s^2] are the joints'; the rest as in
    `forward`. From joint to joint outward: Lynch and Park 2017, section 8.3.
    """
    n = len(q)
    motions = np.empty((n + 1, 3, 4))
    carry(axes, points, q, motions)
    w, alpha, a = np.zeros(3), np.zeros(3), np.zeros(3)  # of the link that the joint sits on
    axis, at, before = np.empty(3), np.zeros(3), np.zeros(3)
    for i in range(n + 1):
        for k in range(3):
            before[k] = at[k]
            if i < n:
                axis[k] = moved(motions[i], axes[i], 0.0, k)
                at[k] = moved(motions[i], points[i], 1.0, k)
            else:
                at[k] = moved(motions[n], X_WH0[:3, 3], X_WH0[3, 3], k)
        lever = at - before
        a += cross(alpha, lever) + cross(w, cross(w, lever))
        if i < n:
            alpha += acceleration[i] * axis + velocity[i] * cross(w, axis)
            w += velocity[i] * axis
    return np.concatenate((alpha, a))


@njit(cache=True)
def holding_torques(
    axes: Array, points: Array, masses: Array, centers: Array, gravity: Array, q: Array
) -> Array:
    """Joint torques (n,) [N m] under which masses rest.

    Mass i (n,) [kg] hangs on joint i; its centre (n, 3) [m] is in W at q = 0, as axes and points
    are. gravity: (3,) [m/s^2].
    """
    n = len(q)
    motions, torques = np.empty((n + 1, 3, 4)), np.empty(n)
    carry(axes, points, q, motions)
    mass, moment = 0.0, np.zeros(3)  # of all that hangs on joint i
    lever, axis = np.empty(3), np.empty(3)
    for i in range(n - 1, -1, -1):
        mass += masses[i]
        for k in range(3):
            moment[k] += masses[i] * moved(motions[i + 1], centers[i], 1.0, k)
            lever[k] = moment[k] - mass * moved(motions[i], points[i], 1.0, k)
            axis[k] = moved(motions[i], axes[i], 0.0, k)
        torques[i] = -np.sum(axis * cross(lever, gravity))
    return torques


@njit(cache=True)
def pose_error(X_target: Array, X: Array) -> Array:
    """Rotation vector and translation (6,) that lead from X to X_target, in W."""
    error = np.empty(6)
    R = np.ascontiguousarray(X_target[:3, :3]) @ np.ascontiguousarray(X[:3, :3].T)
    error[:3] = rotation_vector(R)
    error[3:] = X_target[:3, 3] - X[:3, 3]
    return error


@njit(cache=True)
def pursuit(
    X_target: Array, X: Array, V_target: Array, gain: float, max_angular: float, max_linear: float
) -> Array:
    """`bounded_velocity` towards a pose that moves."""
    error = pose_error(X_target, X) + V_target / gain
    return bounded_velocity(error, gain, max_angular, max_linear)


@njit(cache=True)
def norm(x: Array) -> float:
    """Euclidean length."""
    return float(np.sqrt(np.sum(x * x)))


@njit(cache=True)
def bounded_velocity(error: Array, gain: float, max_angular: float, max_linear: float) -> Array:
    """Spatial velocity (6,) along the error, both its parts within their bounds."""
    scale = gain
    angle, distance = norm(error[:3]), norm(error[3:])
    if angle * scale > max_angular:
        scale = max_angular / angle
    if distance * scale > max_linear:
        scale = max_linear / distance
    return error * scale


@bare_njit
def factor(J: Array, shift: float, L: Array) -> bool:
    """Cholesky factor L (m, m) of J J^T less a multiple of the unit matrix, where it has one."""
    m, n = J.shape
    for i in range(m):
        for k in range(i + 1):
            left = 0.0
            for j in range(n):
                left += J[i, j] * J[k, j]
            for j in range(k):
                left -= L[i, j] * L[k, j]
            if i > k:
                L[i, k] = left / L[k, k]
            elif left - shift > 0.0:  # False for NaN too
                L[i, i] = np.sqrt(left - shift)
            else:
                return False
    return True


@bare_njit
def far_from_singular(J: Array, threshold: float, L: Array) -> bool:
    """Whether all singular values of J exceed a threshold; then L L^T = J J^T.

    They do where J J^T less the threshold's square has a Cholesky factor, which is far quicker to
    find out than the values themselves.
    """
    square = max(threshold * threshold, SINGULAR_VALUE_FLOOR)
    return factor(J, square, L) and factor(J, 0.0, L)


@bare_njit
def solve(L: Array, x: Array) -> None:
    """Solve L L^T y = x (m,); x becomes y."""
    m = len(x)
    for i in range(m):
        for j in range(i):
            x[i] -= L[i, j] * x[j]
        x[i] /= L[i, i]
    for i in range(m - 1, -1, -1):
        for j in range(i + 1, m):
            x[i] -= L[j, i] * x[j]
        x[i] /= L[i, i]


@njit(cache=True)
def damped_inverse_product(J: Array, velocity: Array, threshold: float) -> Array:
    """J^+ velocity, damped along singular directions weaker than `threshold`."""
    L = np.empty((len(J), len(J)))
    if far_from_singular(J, threshold, L):
        components = velocity.copy()
        solve(L, components)
        return J.T @ components
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    components = U.T @ velocity
    for i in range(len(s)):
        damping = 0.0
        if s[i] < threshold:
            damping = (threshold - s[i]) * (threshold + s[i])
        components[i] *= s[i] / max(s[i] * s[i] + damping, SINGULAR_VALUE_FLOOR)
    return Vt.T @ components


@njit(cache=True)
def finite(x: Array) -> bool:
    """Whether all numbers are; far quicker than numpy where they are few."""
    total = 0.0
    for value in x.flat:
        total += 0.0 * value  # NaN where the value is NaN or infinite
    return total == 0.0


@njit(cache=True)
def within(x: Array, largest: float) -> Array:
    """The same direction, no component larger than `largest`; sums of squares can't overflow."""
    most = np.max(np.abs(x))
    return x if most <= largest else x / most * largest


@njit(cache=True)
def scale_to_limits(joint_velocity: Array, velocity_limits: Array) -> Array:
    """The same direction in joint space, no joint faster than its limit."""
    return joint_velocity / max(1.0, np.max(np.abs(joint_velocity) / velocity_limits))


@njit(cache=True)
def null_space_basis(J: Array, tolerance: float) -> Array:
    """Orthonormal columns (n, k) that J maps to zero."""
    _, s, Vt = np.linalg.svd(J, full_matrices=True)
    rank = np.sum(s > tolerance * s[0])
    return np.ascontiguousarray(Vt[rank:].T)


@njit(cache=True)
def limit_avoidance(q: Array, lower: Array, upper: Array) -> Array:
    """Equation 4.5."""
    return np.cos(np.pi * (q - lower) / (upper - lower))


@njit(cache=True)
def joint_velocity(
    J: Array, velocity: Array, q: Array, limits: Array, threshold: float, horizon: float
) -> Array:
    """Joint velocities (n,) within all limits; what a joint near one can't do, others take over.

    limits: at least lower, upper [rad], velocity [rad/s].
    """
    J, velocity = J.copy(), within(velocity, FASTEST)
    low = np.minimum((limits[0] - q) / horizon, 0.0)
    high = np.maximum((limits[1] - q) / horizon, 0.0)
    result = damped_inverse_product(J, velocity, threshold)
    bound = np.zeros(len(q), dtype=np.bool_)
    for _ in range(len(q) - 1):
        kept = np.minimum(np.maximum(result, low), high)
        beyond = (kept != result) & ~bound
        if not np.any(beyond):
            break
        for i in range(len(q)):
            if beyond[i]:
                velocity = velocity - J[:, i] * kept[i]
                J[:, i] = 0.0
        bound |= beyond
        result = np.where(bound, kept, damped_inverse_product(J, velocity, threshold))
    result = np.minimum(np.maximum(result, low), high)
    scaled: Array = scale_to_limits(result, limits[2])
    return scaled


@njit(cache=True)
def null_space_velocity(J: Array, q: Array, lower: Array, upper: Array, threshold: float) -> Array:
    """Equation 4.6 with an orthonormal basis, fading out towards singular postures."""
    wanted = limit_avoidance(q, lower, upper)
    L = np.empty((len(J), len(J)))
    if far_from_singular(J, threshold, L):
        lost = J @ wanted
        solve(L, lost)
        return wanted - J.T @ lost
    _, s, Vt = np.linalg.svd(J, full_matrices=True)
    velocity = np.zeros(len(q))
    for i in range(len(s), len(q)):
        velocity += np.sum(Vt[i] * wanted) * Vt[i]
    return velocity * min(s[-1] / threshold, 1.0) ** 2


@njit(cache=True)
def largest_share(base: Array, addition: Array, low: Array, high: Array) -> float:
    """The largest share in 0..1 of `addition` that keeps the sum within low and high."""
    share = 1.0
    for i in range(len(base)):
        room = max(high[i] - base[i] if addition[i] > 0.0 else base[i] - low[i], 0.0)
        if np.abs(addition[i]) * share > room:
            share = room / np.abs(addition[i])
    return share


@njit(cache=True)
def add_avoidance(
    base: Array, J: Array, q: Array, limits: Array, gain: float, threshold: float, horizon: float
) -> Array:
    """Equation 4.7 within all limits.

    What is best for the arm as a whole can push a joint out of its range. Then only a share of it
    is added, and for the rest what the other joints can do while those stand still: so nothing
    jumps as a joint comes to its limit.
    limits: at least lower, upper [rad], velocity [rad/s].
    """
    low = np.maximum(np.minimum((limits[0] - q) / horizon, 0.0), -limits[2])
    high = np.minimum(np.maximum((limits[1] - q) / horizon, 0.0), limits[2])
    total = np.minimum(np.maximum(scale_to_limits(base, limits[2]), low), high)
    addition = gain * null_space_velocity(J, q, limits[0], limits[1], threshold)
    share = largest_share(total, addition, low, high)
    pushed = (total + addition > high) | (total + addition < low)
    total = total + share * addition
    if share < 1.0:
        rest = null_space_velocity(np.where(pushed, 0.0, J), q, limits[0], limits[1], threshold)
        rest = (1.0 - share) * gain * np.where(pushed, 0.0, rest)
        total = total + largest_share(total, rest, low, high) * rest
    return total


@njit(cache=True)
def stopping_speed(distance: float, acceleration: float, dt: float) -> float:
    """The largest speed over one period from which a joint stops within a distance.

    It moves on by v dt and then slows down by a dt a period:
    v = sqrt(2 a d) - a dt / 2, and for a stop in the next period d / dt or a dt.
    """
    d = max(distance, 0.0)
    at_once = min(d / dt, acceleration * dt)
    return max(at_once, np.sqrt(2.0 * acceleration * d) - 0.5 * acceleration * dt)


@njit(cache=True)
def limited_change(wanted: Array, q: Array, velocity: Array, limits: Array, dt: float) -> Array:
    """Joint velocities (n,) for the next period, on the straight way from `velocity` to `wanted`.

    No joint exceeds its velocity or acceleration, nor moves so fast that it could not stop
    before a position limit. Where q and velocity are such already, the position limits go first.
    limits (4, n): lower, upper [rad], velocity [rad/s], acceleration [rad/s²].
    """
    now = np.minimum(np.maximum(velocity, -limits[2]), limits[2])
    change = scale_to_limits(wanted, limits[2]) - now
    result = now + scale_to_limits(change, limits[3] * dt)
    for i in range(len(q)):
        down = stopping_speed(q[i] - limits[0, i], limits[3, i], dt)
        up = stopping_speed(limits[1, i] - q[i], limits[3, i], dt)
        result[i] = min(max(result[i], -down), up)
    return np.minimum(np.maximum(result, -limits[2]), limits[2])


@njit(cache=True)
def next_state(wanted: Array, state: Array, limits: Array, dt: float) -> Array:
    """Positions and velocities (2 n,) after a period of `limited_change`."""
    n = len(wanted)
    velocity = limited_change(wanted, state[:n], state[n:], limits, dt)
    after = np.empty(2 * n)
    # Clamped, since the sum is rounded.
    after[:n] = np.minimum(np.maximum(state[:n] + dt * velocity, limits[0]), limits[1])
    after[n:] = velocity
    return after


@njit(cache=True)
def control_step(
    J: Array, error: Array, q: Array, limits: Array, bounds: Array, gains: Array
) -> Array:
    """Joint velocities (n,) of the three controllers in a row.

    limits: at least lower, upper, velocity. bounds: angular, linear.
    gains: position gain, singular threshold, p_N, limit horizon [s].
    """
    velocity = bounded_velocity(error, gains[0], bounds[0], bounds[1])
    result: Array = joint_velocity(J, velocity, q, limits, gains[1], gains[3])
    return add_avoidance(result, J, q, limits, gains[2], gains[1], gains[3])


@njit(cache=True)
def roll_to_pose(
    axes: Array,
    points: Array,
    X_WH0: Array,
    X_target: Array,
    limits: Array,
    bounds: Array,
    gains: Array,
    tolerances: Array,
    dt: float,
    path: Array,
    start: int,
) -> tuple[int, bool]:
    """Follow the controllers from path[start] to one pose; fills `path` (m, n).

    limits (4, n): lower, upper [rad], velocity [rad/s], acceleration [rad/s²].
    tolerances: angle [rad], position [m], patience [s] without progress.

    Returns:
        The index of the last filled row, whether the pose was reached.
    """
    best, best_row = np.inf, start
    velocity = np.zeros(path.shape[1])
    if start > 0:
        velocity = (path[start] - path[start - 1]) / dt
    row = start
    while True:
        X, J = forward(axes, points, X_WH0, path[row])
        error = pose_error(X_target, X)
        angle, distance = norm(error[:3]), norm(error[3:])
        if angle <= tolerances[0] and distance <= tolerances[1]:
            return row, True
        remaining = max(angle / tolerances[0], distance / tolerances[1])
        if remaining < 0.99 * best:
            best, best_row = remaining, row
        if row + 1 == len(path) or (row - best_row) * dt > tolerances[2]:
            return row, False
        wanted = control_step(J, error, path[row], limits, bounds, gains)
        velocity = limited_change(wanted, path[row], velocity, limits, dt)
        row += 1
        path[row] = np.minimum(np.maximum(path[row - 1] + dt * velocity, limits[0]), limits[1])


@njit(cache=True)
def refine_ik(
    axes: Array,
    points: Array,
    X_WH0: Array,
    X_target: Array,
    q: Array,
    limits: Array,
    tolerances: Array,
    steps: int,
) -> tuple[Array, bool]:
    """Damped least squares from q within the joint limits, joints drawn to their middles.

    tolerances: angle [rad], position [m]. A seed that stops improving is given up early.
    """
    middle, span = 0.5 * (limits[0] + limits[1]), limits[1] - limits[0]
    best, since = np.inf, 0
    for _ in range(steps):
        X, J = forward(axes, points, X_WH0, q)
        error = pose_error(X_target, X)
        if norm(error[:3]) <= tolerances[0] and norm(error[3:]) <= tolerances[1]:
            return q, True
        size = norm(error[:3]) + 3.0 * norm(error[3:])
        if size < 0.95 * best:
            best, since = size, 0
        since += 1
        if since > 12:
            break
        error *= min(1.0, 0.8 / size)
        damping = 1e-5 + 1e-3 * min(size, 1.0)
        pull = 0.3 * (middle - q) / span
        inverse = np.linalg.inv(J @ J.T + damping * np.eye(6))
        q = q + pull + J.T @ (inverse @ (error - J @ pull))
        q = np.minimum(np.maximum(q, limits[0]), limits[1])
    return q, False
