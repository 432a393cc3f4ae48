"""Lift models for tests."""

import numpy as np
import torch

from vh_drake.learning.calibration import Calibration
from vh_drake.learning.forest import Forest
from vh_drake.learning.lift_model import Judge, LiftModel, fingerprint
from vh_drake.learning.lift_network import LiftNetwork


def linear_model(metric, slopes, column=0):
    """Judges whose logit is a slope times one number, positive or not, for a metric."""
    judges, node = [], np.zeros(1, np.int64)
    undecided = Forest(node, node, np.zeros(1), node, node, np.full(1, 0.5), 1)
    for slope in slopes:
        network = LiftNetwork()
        with torch.no_grad():
            for value in network.parameters():
                value.zero_()
            first, last = network.fusion[0], network.fusion[-1]
            first.weight[0, network.dense.out_features + column] = 1.0
            first.weight[1, network.dense.out_features + column] = -1.0
            last.weight[0, :2] = 2 * torch.tensor([slope, -slope])
        judges.append(Judge(network.eval(), undecided))
    return LiftModel(tuple(judges), Calibration(), {"metric": fingerprint(metric)})
