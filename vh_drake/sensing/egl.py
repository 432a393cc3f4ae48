"""Whether this machine can render without a display."""

import functools
import subprocess
import sys

_RENDER = """
from pydrake.geometry import (
    ClippingRange, DepthRange, DepthRenderCamera, FrameId, MakeRenderEngineVtk,
    RenderCameraCore, RenderEngineVtkParams, SceneGraph)
from pydrake.math import RigidTransform
from pydrake.systems.sensors import CameraInfo
scene_graph = SceneGraph()
scene_graph.AddRenderer("r", MakeRenderEngineVtk(RenderEngineVtkParams(backend="EGL")))
core = RenderCameraCore("r", CameraInfo(8, 8, 0.8), ClippingRange(0.1, 5.0), RigidTransform())
query = scene_graph.get_query_output_port().Eval(scene_graph.CreateDefaultContext())
camera = DepthRenderCamera(core, DepthRange(0.2, 3.0))
image = query.RenderDepthImage(camera, scene_graph.world_frame_id(), RigidTransform())
raise SystemExit(0 if image.width() == 8 else 1)
"""


@functools.cache
def egl_available() -> bool:
    """Renders one tiny depth image in a process of its own; asked once a process.

    A driver that crashes takes only that process with it; one that hangs counts as missing.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-c", _RENDER], capture_output=True, timeout=60, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0
