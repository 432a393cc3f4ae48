import numpy as np
import torch

from vh_drake.learning.lift_inputs import LIFT_NUMBERS
from vh_drake.learning.lift_network import LiftNetwork
from vh_drake.learning.network import SEEN, GraspNetwork


def begun():
    torch.manual_seed(0)
    network, metric = LiftNetwork(), GraspNetwork()
    numbers = 3.0 + 2.0 * torch.randn(500, LIFT_NUMBERS)
    network.begin(metric, numbers)
    return network, metric, numbers


def test_it_begins_with_the_units_of_the_metric():
    network, metric, _ = begun()
    seen = torch.rand(5, SEEN)
    network.eval()
    torch.testing.assert_close(network.hidden(seen), torch.relu(metric.dense(seen)))


def test_the_unit_of_a_number_does_not_matter():
    network, metric, numbers = begun()
    network.eval()
    seen = torch.rand(5, SEEN)
    before = network(seen, numbers[:5])
    network.begin(metric, 10.0 * numbers - 4.0)
    torch.testing.assert_close(network(seen, 10.0 * numbers[:5] - 4.0), before, rtol=0, atol=2e-3)


def test_dropout_acts_only_while_training():
    network, _, numbers = begun()
    seen = torch.rand(5, SEEN)
    outputs = {
        mode: [network.train(mode)(seen, numbers[:5]).detach().numpy() for _ in range(2)]
        for mode in (True, False)
    }
    assert np.abs(outputs[True][0] - outputs[True][1]).max() > 1e-3
    np.testing.assert_array_equal(*outputs[False])
