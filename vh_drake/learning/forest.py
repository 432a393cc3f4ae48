"""Randomized trees (Geurts et al. 2006) that foretell a yes or no from few numbers."""

import dataclasses as dc
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import ExtraTreesClassifier

from vh_drake.errors import BadInput
from vh_drake.geometry.meshes import Mask
from vh_drake.types import Array, IntArray

_SURE = 1e-3  # mean shares nearer to 0 or 1 are all alike
_DEEPEST = 1000


@dc.dataclass(frozen=True, eq=False)
class Forest:
    """t binary trees with k nodes in all; a leaf is its own child."""

    root: IntArray  # (t,) node in which a tree starts
    feature: IntArray  # (k,) which number a node looks at
    threshold: Array  # (k,) at most this: to the left
    left: IntArray  # (k,)
    right: IntArray  # (k,)
    share: Array  # (k,) of the samples in a node that say yes
    depth: int  # of the deepest leaf

    def shares(self, numbers: Array) -> Array:
        """The share of each tree's leaf (n, t) of numbers (n, ...)."""
        x = np.asarray(numbers, np.float32)  # What trees are grown on
        node = np.tile(self.root, (len(x), 1))
        row = np.arange(len(x))[:, None]
        for _ in range(self.depth):
            smaller = x[row, self.feature[node]] <= self.threshold[node]
            node = np.where(smaller, self.left[node], self.right[node])
        shares: Array = self.share[node]
        return shares

    def logits(self, numbers: Array) -> Array:
        """Log odds (n,) of the trees' mean share."""
        mean = np.clip(self.shares(numbers).mean(axis=1), _SURE, 1 - _SURE)
        odds: Array = np.log(mean / (1 - mean))
        return odds

    def arrays(self) -> dict[str, NDArray[Any]]:
        """As they are kept; thresholds are exact, as what lies on one is not to change sides."""
        return {name: getattr(self, name).astype(kind) for name, kind in _KEPT.items()}


_KEPT = {
    "root": np.int32,
    "feature": np.int32,
    "threshold": np.float64,
    "left": np.int32,
    "right": np.int32,
    "share": np.float32,
}


def read_forest(arrays: Mapping[str, NDArray[Any]], depth: Any, numbers: int) -> Forest:
    """A forest from its arrays.

    Args:
        arrays: as `Forest.arrays` gives them.
        depth: of the deepest leaf.
        numbers: how many the trees may look at.

    Raises:
        BadInput: an array is missing, or the trees lead nowhere.
    """
    try:
        parts: dict[str, Any] = {
            name: arrays[name].astype(np.float64 if kind in _REAL else np.int64)
            for name, kind in _KEPT.items()
        }
        forest = Forest(**parts, depth=int(depth))
    except (KeyError, ValueError, TypeError) as error:
        raise BadInput("these are no trees") from error
    if not _is_sound(forest, numbers):
        raise BadInput("its trees lead nowhere, or look at other inputs")
    return forest


_REAL = (np.float64, np.float32)


def _is_sound(forest: Forest, numbers: int) -> bool:
    """Whether every index is within bounds."""
    nodes = forest.share.shape
    columns = (forest.feature, forest.threshold, forest.left, forest.right)
    if len(nodes) != 1 or any(column.shape != nodes for column in columns):
        return False
    links = np.concatenate([forest.root.ravel(), forest.left, forest.right])
    inside = (links >= 0) & (links < nodes[0])
    known = (forest.feature >= 0) & (forest.feature < numbers)
    return bool(inside.all() and known.all() and len(forest.root) and 0 < forest.depth < _DEEPEST)


def grow_forest(
    numbers: Array, yes: Mask, *, trees: int, leaf: int, numbers_share: float, seed: int
) -> Forest:
    """Trees of numbers (n, ...) and outcomes (n,).

    Args:
        numbers: of the samples.
        yes: their outcomes.
        trees: how many.
        leaf: samples at least in each leaf.
        numbers_share: of the numbers, among which a node chooses.
        seed: of every random choice.
    """
    forest = ExtraTreesClassifier(
        trees, min_samples_leaf=leaf, max_features=numbers_share, random_state=seed
    ).fit(numbers.astype(np.float32), yes)
    own = [estimator.tree_ for estimator in forest.estimators_]
    root = np.cumsum([0, *(tree.node_count for tree in own[:-1])])
    return Forest(
        root=root,
        feature=np.concatenate([np.maximum(tree.feature, 0) for tree in own]),
        threshold=np.concatenate([tree.threshold for tree in own]),
        left=_linked([tree.children_left for tree in own], root),
        right=_linked([tree.children_right for tree in own], root),
        share=np.concatenate([tree.value[:, 0, 1] for tree in own]),
        depth=max(tree.max_depth for tree in own),
    )


def _linked(children: list[IntArray], root: IntArray) -> IntArray:
    """Children by their place among the nodes of all trees; a leaf is its own."""
    linked = [
        first + np.where(own < 0, np.arange(len(own)), own)
        for own, first in zip(children, root, strict=True)
    ]
    return np.concatenate(linked)
