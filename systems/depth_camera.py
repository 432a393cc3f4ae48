"""A structured-light camera as a LeafSystem."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context
from pydrake.systems.sensors import ImageDepth32F

from vh_drake.errors import BadInput
from vh_drake.sensing.depth_noise import DepthNoiseSettings, add_depth_noise
from vh_drake.sensing.intrinsics import Intrinsics
from vh_drake.sensing.point_cloud import cloud_from_depth
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Cloud


class DepthCamera(CollectableSystem):
    """Adds the noise of a structured-light camera to a depth image, and makes a cloud of it.

    .. pydrake_system::

        name: DepthCamera
        input_ports:
        - depth_image
        - X_WC
        output_ports:
        - depth_image
        - cloud

    | port        | direction | type             | unit | meaning                               |
    |-------------|-----------|------------------|------|---------------------------------------|
    | depth_image | in        | ImageDepth32F    | m    | perfect depth, 0 or inf: nothing seen |
    | X_WC        | in        | RigidTransform   | m    | optical frame: +z forward, +y down    |
    | depth_image | out       | ImageDepth32F    | m    | noisy depth, 0: nothing measured      |
    | cloud       | out       | Cloud            | m    | what was measured, in W               |

    The noise is a function of seed and time, so the system has no state, and an image of one
    instant is the same however often it is evaluated.

    Args:
        intrinsics: the camera.
        settings: the noise model's knobs.
        seed: of the noise.
        X_CBelieved: where the calibration puts the camera, in its true frame; exactly there
            unless given.
    """

    def __init__(
        self,
        intrinsics: Intrinsics,
        settings: DepthNoiseSettings | None = None,
        seed: int = 0,
        X_CBelieved: RigidTransform | None = None,
    ) -> None:
        super().__init__()
        self._intrinsics = intrinsics
        self._settings = settings or DepthNoiseSettings()
        self._seed = seed
        self._X_CBelieved = RigidTransform() if X_CBelieved is None else X_CBelieved
        blank = ImageDepth32F(intrinsics.width, intrinsics.height)
        self._depth = self.DeclareAbstractInputPort("depth_image", Value(blank))
        self._X_WC = self.DeclareAbstractInputPort("X_WC", Value(RigidTransform()))
        self._noisy = self.DeclareAbstractOutputPort(
            "depth_image",
            lambda: Value(ImageDepth32F(intrinsics.width, intrinsics.height)),
            self._calc_depth,
            prerequisites_of_calc={self._depth.ticket(), self.time_ticket()},
        )
        self.DeclareAbstractOutputPort(
            "cloud",
            lambda: Value[object](Cloud()),
            self._calc_cloud,
            prerequisites_of_calc={
                self._depth.ticket(),
                self._X_WC.ticket(),
                self.time_ticket(),
            },
        )

    def _calc_depth(self, context: Context, output: Value) -> None:
        image = self._depth.Eval(context)
        if (image.height(), image.width()) != (self._intrinsics.height, self._intrinsics.width):
            raise BadInput(
                f"DepthCamera got an image of {image.height()} x {image.width()} pixels for a "
                f"camera of {self._intrinsics.height} x {self._intrinsics.width}"
            )
        rng = np.random.default_rng([self._seed, max(0, round(context.get_time() * 1e6))])
        noisy = add_depth_noise(image.data[:, :, 0], self._intrinsics, rng, self._settings)
        output.get_mutable_value().mutable_data[:, :, 0] = noisy

    def _calc_cloud(self, context: Context, output: Value) -> None:
        depth = self._noisy.Eval(context).data[:, :, 0]
        X_WC = (self._X_WC.Eval(context) @ self._X_CBelieved).GetAsMatrix4()
        output.set_value(cloud_from_depth(depth, self._intrinsics, X_WC))
