"""Segmentation of the object on the table as a LeafSystem."""

from pydrake.common.value import Value
from pydrake.systems.framework import Context, ValueProducer

from vh_drake.errors import NothingSeen
from vh_drake.sensing.segmentation import SegmentationSettings, segment
from vh_drake.systems.collectable import CollectableSystem
from vh_drake.types import Cloud, ObjectView


class ObjectSegmenter(CollectableSystem):
    """Cuts the one object on the table out of a cloud.

    .. pydrake_system::

        name: ObjectSegmenter
        input_ports:
        - cloud
        output_ports:
        - object_view
        - status

    | port        | direction | type       | unit | meaning                                       |
    |-------------|-----------|------------|------|-----------------------------------------------|
    | cloud       | in        | Cloud      | m    | what the camera saw, in W                     |
    | object_view | out       | ObjectView | m    | points, normals, table; empty if nothing seen |
    | status      | out       | str        | -    | "ok", or why nothing was seen                 |

    A simulation goes on where nothing is seen: `status` says why, whoever needs the object
    decides.

    Args:
        settings: where to look and what counts as object.
    """

    def __init__(self, settings: SegmentationSettings | None = None) -> None:
        super().__init__()
        self._settings = settings or SegmentationSettings()
        self._cloud = self.DeclareAbstractInputPort("cloud", Value[object](Cloud()))
        self._result = self.DeclareCacheEntry(
            description="object view and status",
            value_producer=ValueProducer(
                lambda: Value[object](None), self.weakly(self._calc_result)
            ),
            prerequisites_of_calc={self._cloud.ticket()},
        ).cache_index()  # The entry itself would keep this system for ever.
        self.DeclareAbstractOutputPort(
            "object_view",
            lambda: Value[object](ObjectView()),
            lambda context, output: output.set_value(self._evaluated(context)[0]),
            prerequisites_of_calc={self._cloud.ticket()},
        )
        self.DeclareAbstractOutputPort(
            "status",
            lambda: Value[str]("ok"),
            lambda context, output: output.set_value(self._evaluated(context)[1]),
            prerequisites_of_calc={self._cloud.ticket()},
        )

    def _evaluated(self, context: Context) -> tuple[ObjectView, str]:
        result: tuple[ObjectView, str] = self.get_cache_entry(self._result).Eval(context)
        return result

    def _calc_result(self, context: Context, output: Value) -> None:
        try:
            result = segment(self._cloud.Eval(context), self._settings), "ok"
        except NothingSeen as error:
            result = ObjectView(), str(error)
        output.set_value(result)
