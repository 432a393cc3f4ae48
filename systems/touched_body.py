"""Where one body of a plant is, and the force of all contacts on it."""

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import BasicVector, Context

from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Array


class TouchedBody(CollectableSystem):
    """Pose of a body, and what touches it added up.

    .. pydrake_system::

        name: TouchedBody
        input_ports:
        - contact_results
        - body_poses
        output_ports:
        - contact_force
        - body_pose

    | port            | direction | type                 | unit | meaning                 |
    |-----------------|-----------|----------------------|------|-------------------------|
    | contact_results | in        | ContactResults       | SI   | of the plant            |
    | body_poses      | in        | list[RigidTransform] | m    | of the plant            |
    | contact_force   | out       | vector (3)           | N    | on the body, in W       |
    | body_pose       | out       | RigidTransform       | m    | of the body in W        |

    Args:
        plant: finalized; kept, for it tells the bodies of geometries.
        body: of the plant.
    """

    def __init__(self, plant: MultibodyPlant, body: RigidBody) -> None:
        super().__init__()
        self._index = body.index()
        self._geometries = set(plant.GetCollisionGeometriesForBody(body))
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self.DeclareVectorOutputPort(
            "contact_force",
            3,
            self._calc_force,
            prerequisites_of_calc={self._results.ticket()},
        )
        self._poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]([]))
        self.DeclareAbstractOutputPort(
            "body_pose",
            lambda: Value(RigidTransform()),
            self._calc_pose,
            prerequisites_of_calc={self._poses.ticket()},
        )

    def _calc_force(self, context: Context, output: BasicVector) -> None:
        results: ContactResults = self._results.Eval(context)
        force: Array = np.zeros(3)
        for i in range(results.num_hydroelastic_contacts()):
            info = results.hydroelastic_contact_info(i)
            surface = info.contact_surface()  # F_Ac_W acts on the body of geometry M.
            on_m = np.asarray(info.F_Ac_W().translational())
            force += (surface.id_M() in self._geometries) * on_m
            force -= (surface.id_N() in self._geometries) * on_m
        for i in range(results.num_point_pair_contacts()):
            pair = results.point_pair_contact_info(i)
            on_b = np.asarray(pair.contact_force())
            force += (pair.bodyB_index() == self._index) * on_b
            force -= (pair.bodyA_index() == self._index) * on_b
        output.SetFromVector(force)

    def _calc_pose(self, context: Context, output: Value) -> None:
        output.set_value(self._poses.Eval(context)[int(self._index)])
