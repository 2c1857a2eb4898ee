"""Section IV written out one number at a time, from the paper alone: what the fast code is compared with.

Everything is double precision, for one torque and one guess. The only thing borrowed is Eq. 1, which
test_dynamics.py checks against other programs, and the metric, which test_metric.py checks.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F  # noqa: N812

from repro.cnn.architecture import NetworkSettings
from repro.cnn.network import FactoredCNN
from repro.model.dynamics import inverse_dynamics
from repro.signals.metric import metr2ev

# Published test arms (Tables 4 and 5).
ARMS = {
    "N1": np.array([0.6590, 0.4156, 0.5578, 0.9296, 0.1349, 0.3850, 0.4875, 0.1472, 0.1044]),
    "N2": np.array([0.6259, 0.4901, 0.8725, 0.5148, 0.7013, 0.3372, 0.0574, 0.0345, 0.1668]),
    "N3": np.array([0.5020, 0.9779, 0.5040, 0.4777, 0.5724, 0.0715, 0.3820, 0.0972, 0.5721]),
    "N4": np.array([0.6944, 0.5271, 0.3408, 0.3536, 0.8523, 0.5325, 0.4714, 0.1361, 0.2451]),
}

#: A network small enough for tests; its images are 44 x 44 x 2.


@dataclass(frozen=True)
class Sizes(NetworkSettings):
    """Other sizes than the paper's."""

    image_size: int = 100
    maps: int = 10
    kernels: tuple[int, int, int] = (9, 5, 3)


SMALL = Sizes(hidden=(16, 8), image_size=44, maps=4)


def cosines(n):
    """Matrix of Eq. 5: row k holds the k-th orthonormal cosine."""
    k, i = np.arange(n)[:, None], np.arange(n)[None, :]
    matrix = np.sqrt(2 / n) * np.cos(np.pi * k * (2 * i + 1) / (2 * n))
    matrix[0] /= np.sqrt(2)
    return matrix


def low_pass(x, h, c_f):
    """Eq. 14 with omega as the number of the band, so that the sampling period does not matter."""
    n = x.shape[-1]
    matrix = cosines(n)
    return (matrix.T @ (np.exp(-c_f * np.arange(n) ** 2)[:, None] * (matrix @ x.T))).T


def derivative(x, h, c_f):
    """Eq. 6; the first sample has no predecessor and takes its neighbour's difference."""
    difference = np.empty_like(x)
    for i in range(1, x.shape[-1]):
        difference[:, i] = (x[:, i] - x[:, i - 1]) / h
    difference[:, 0] = difference[:, 1]
    return low_pass(difference, h, c_f)


def subsample(x, m):
    """Fig. 5: the first m bands, back at length m, levels kept."""
    n = x.shape[-1]
    return (cosines(m).T @ (cosines(n)[:m] @ x.T)).T * math.sqrt(m / n)


def image(alpha, psi, scale="shared-max", constant=4.0):
    """Eq. 9 for one pair of (2, S) signals: an array (2, S, S), rows psi, columns alpha."""

    def normalize(x):
        both = [x, x] if scale != "channel-max" else [x[0:1], x[1:2]]
        return np.stack([(x[d] - both[d].min()) / (both[d].max() - both[d].min()) for d in (0, 1)])

    alpha2 = np.array([[math.log(a + 1e-3) for a in row] for row in normalize(alpha)])
    psi2 = np.array([[math.log10(p + 1e-3) for p in row] for row in normalize(psi)])
    z1 = np.stack([np.outer(psi[d], alpha[d]) for d in (0, 1)])
    z2 = np.stack([np.outer(psi2[d], alpha2[d]) for d in (0, 1)])

    def largest(z):
        if scale == "channel-max":
            return np.array([np.abs(z[0]).max(), np.abs(z[1]).max()]).reshape(2, 1, 1)
        return np.abs(z).max()

    return z1 / (constant if scale == "constant" else largest(z1)) + z2 / largest(z2)


def read(network, picture):
    """Lines 19 and 20: sigmoid of the output layer, then its inverse."""
    with torch.no_grad():
        y = 1 / (1 + np.exp(-network(torch.from_numpy(picture)[None]).numpy()[0]))
    return -np.log((1 - y) / y)


class SignalCNN(FactoredCNN):
    """The same layers, applied to images (n, 2, 100, 100) as Fig. 7 and Table 3 have them."""

    def forward(self, image):
        x = F.max_pool2d(F.relu(self.conv1(image)), 2)  # (n, 2, 100, 100) -> (n, 10, 92, 92) -> (n, 10, 46, 46)
        x = F.max_pool2d(F.relu(self.conv2(x)), 2)  # -> (n, 10, 42, 42) -> (n, 10, 21, 21)
        x = F.relu(self.conv3(x))  # -> (n, 10, 19, 19)
        x = F.relu(self.fc4(x.flatten(1)))  # (n, 3610) -> (n, 100)
        return self.fc6(F.relu(self.fc5(x)))  # -> (n, 50) -> (n, 9)


def plain_twin(network):
    """The plain network with the same weights, in double precision."""
    twin = SignalCNN(network.settings)
    twin.load_state_dict(network.state_dict())
    return twin.double()


def untrained(gain=1.0):
    """A network with random weights and no bias, whose residuals are multiplied by `gain`."""
    torch.manual_seed(0)
    network = FactoredCNN(SMALL).requires_grad_(False)
    network.fc6.weight *= gain
    return network


def algorithm1(network, q, tau, tau_mean, signals, cut, search, streams, scale="shared-max"):
    """Algorithm 1 line by line, one guess at a time.

    Returns beta_m, the execution and n_e of each of its rows, the images read, beta_o and its similarity.
    """
    h, c_f, m = signals.sampling_period_s, signals.filter_coefficient, signals.image_samples
    dq = derivative(q, h, c_f)  # 1
    ddq = derivative(dq, h, c_f)  # 2
    tau = low_pass(tau, h, c_f)  # 3
    q_c, dq_c, ddq_c, tau_c = (x[:, cut[0] : cut[1]] for x in (q, dq, ddq, tau))  # 4
    c_p = np.mean([np.linalg.norm(tau_mean[:, k]) / np.linalg.norm(tau_c[:, k]) for k in range(tau_c.shape[1])])  # 5
    tau_c = tau_c * c_p  # 6
    *motion, tau_s = (subsample(x, m) for x in (q_c, dq_c, ddq_c, tau_c))  # 7
    u, i_1, o_v = search.threshold, search.executions, search.inner_limit  # 8, 9, 10
    beta_m, execution, similarity, images = [], [], [], 0  # 11
    unit = np.abs(tau_s).max()
    tau_n = tau_s / unit  # 12
    image_motion = [x / np.abs(x).max(1, keepdims=True) for x in motion] if signals.normalise_motion else motion
    for k_t in range(i_1):  # 13
        n_e, n_it = 0.0, 0  # 14, 15
        while n_e < u and n_it < o_v:  # 16
            beta_n = streams[k_t].uniform(search.guess_low, search.guess_high, 9)  # 17
            picture = image(tau_n, 2 * tau_n - inverse_dynamics(*image_motion, beta_n), scale)  # 18
            r = read(network, picture)  # 19, 20
            images += 1
            beta = r + beta_n  # 21
            if np.any(beta <= 0):  # 22
                n_e = 0.0  # 23, 24
            else:
                tau_r = inverse_dynamics(*motion, beta)  # 26
                n_e = 0.5 * sum(float(metr2ev(tau_n[j], tau_r[j], search.metric).total) for j in (0, 1))  # 27
                beta_m.append(beta)  # 29
                execution.append(k_t)
                similarity.append(n_e)
            n_it += 1  # 28
    if not beta_m:
        return np.empty((0, 9)), [], [], images, np.zeros(9), 0.0
    full = [metr2ev(tau_c / unit, inverse_dynamics(q_c, dq_c, ddq_c, b), search.metric).total.mean() for b in beta_m]
    best = int(np.argmax(full))
    beta_o = beta_m[best]  # 30
    tau_r = inverse_dynamics(q_c, dq_c, ddq_c, beta_o)  # 31
    beta_o = beta_o * np.abs(tau_c).max() / (c_p * np.abs(tau_r).max())  # 32
    return np.array(beta_m), execution, similarity, images, beta_o, full[best]


class Estimator:
    """Stands in for a network with its torque: estimates are a function of the guesses."""

    def __init__(self, answer):
        self.images, self._answer = 0, answer

    def estimate(self, guess):
        self.images += len(guess)
        return self._answer(guess)
