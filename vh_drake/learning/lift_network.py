"""The network that foretells lifts; it begins as the metric's, which has seen far more grasps.

Simulated lifts are dear, so only little is learnt from them: what the metric's convolutions see
of the shape around the hand goes through a dense layer that starts as the metric's own, and
meets the named numbers of `lift_inputs` in a small one.
"""

import torch
from torch import nn
from torch.nn.functional import dropout

from vh_drake.learning.lift_inputs import LIFT_NUMBERS
from vh_drake.learning.network import DROPOUT, HIDDEN, SEEN, GraspNetwork

_FUSED = 64
_DROPOUT_SEEN, _DROPOUT_FUSED = 0.7, 0.3
_LEAST_SCALE = 1e-3  # of numbers that hardly vary


class LiftNetwork(nn.Module):
    """Logits (n,) of a lift, from the output of the metric's convolutions and numbers."""

    mean: torch.Tensor
    scale: torch.Tensor

    def __init__(self) -> None:
        super().__init__()
        self.dense = nn.Linear(SEEN, HIDDEN)
        self.fusion = nn.Sequential(
            nn.Linear(HIDDEN + LIFT_NUMBERS, _FUSED),
            nn.ReLU(),
            nn.Dropout(_DROPOUT_FUSED),
            nn.Linear(_FUSED, 1),
        )
        self.register_buffer("mean", torch.zeros(LIFT_NUMBERS))
        self.register_buffer("scale", torch.ones(LIFT_NUMBERS))

    def begin(self, metric: GraspNetwork, numbers: torch.Tensor) -> None:
        """Take over the metric's dense layer, and the scale of the numbers (n, LIFT_NUMBERS)."""
        self.dense.load_state_dict(metric.dense.state_dict())
        self.mean.copy_(numbers.mean(dim=0))
        self.scale.copy_(numbers.std(dim=0) + _LEAST_SCALE)

    def forward(self, seen: torch.Tensor, numbers: torch.Tensor) -> torch.Tensor:
        """Logits (n,) of convolutions' output (n, SEEN) and numbers (n, LIFT_NUMBERS)."""
        return self.decide(self.hidden(seen), numbers)

    def hidden(self, seen: torch.Tensor) -> torch.Tensor:
        """Units (n, HIDDEN) from the convolutions' output; while training, with dropout."""
        units = torch.relu(self.dense(dropout(seen, _DROPOUT_SEEN, self.training)))
        return dropout(units, DROPOUT, self.training)

    def decide(self, hidden: torch.Tensor, numbers: torch.Tensor) -> torch.Tensor:
        """Logits (n,) from the units, which need not be computed again for other numbers."""
        scaled = (numbers - self.mean) / self.scale
        logits: torch.Tensor = self.fusion(torch.cat([hidden, scaled], dim=1))[:, 0]
        return logits
