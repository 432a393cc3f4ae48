"""The phase as text in Meshcat."""

from pydrake.common import MemoryFile
from pydrake.common.value import Value
from pydrake.geometry import InMemoryMesh, Mesh, Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from vh_drake.geometry.billboard import text_billboard
from vh_drake.systems.meshcat_publisher import PERIOD_S, MeshcatPublisher, Picture


class PhasePublisher(MeshcatPublisher):
    """Shows what the robot is about to do on a sign in the scene.

    .. pydrake_system::

        name: PhasePublisher
        input_ports:
        - phase

    | port  | direction | type | unit | meaning          |
    |-------|-----------|------|------|------------------|
    | phase | in        | str  | -    | of the behaviour |

    Meshcat has no text; the sign is a rectangle with a picture of it.

    Args:
        meshcat: where it draws.
        X_WSign: its centre; the text runs along x and stands along z, and reads from -y.
        height_m: of the sign [m].
        path: under which it draws.
        period_s: between two looks.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        X_WSign: RigidTransform,
        *,
        height_m: float = 0.1,
        path: str = "/phase",
        period_s: float = PERIOD_S,
    ) -> None:
        super().__init__(meshcat, path, period_s)
        self._height_m = height_m
        self._phase = self.DeclareAbstractInputPort("phase", Value[str](""))
        meshcat.SetTransform(path, X_WSign)

    def picture(self, context: Context) -> Picture:
        """The text, if there is one."""
        phase: str = self._phase.Eval(context)
        return (phase,) if phase else ()

    def draw(self, path: str, *picture: object) -> None:
        """Puts a sign under a path."""
        (text,) = picture
        assert isinstance(text, str)
        sign = MemoryFile(text_billboard(text, height_m=self._height_m), ".gltf", "phase")
        self._meshcat.SetObject(path, Mesh(InMemoryMesh(mesh_file=sign)))
