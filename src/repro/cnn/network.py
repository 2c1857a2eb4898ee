"""The CNN of Fig. 7 and Table 3, written plainly: the reference that the factored one is tested against."""

import torch
import torch.nn.functional as F  # noqa: N812  (torch's own convention)
from torch import Tensor, nn

from repro.cnn.architecture import NetworkSettings


class SignalCNN(nn.Module):
    """Convolution 9-pool-5-pool-3, then three fully connected layers.

    Parameters
    ----------
    settings : NetworkSettings
        Sizes.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        super().__init__()
        self.settings = settings
        k1, k2, k3 = settings.kernels
        maps, side = settings.maps, settings.pooled[2]
        self.conv1 = nn.Conv2d(2, maps, k1)
        self.conv2 = nn.Conv2d(maps, maps, k2)
        self.conv3 = nn.Conv2d(maps, maps, k3)
        self.fc4 = nn.Linear(maps * side * side, settings.hidden[0])
        self.fc5 = nn.Linear(settings.hidden[0], settings.hidden[1])
        self.fc6 = nn.Linear(settings.hidden[1], 9)
        for layer in self.children():  # keeps the variance of activations through ReLU layers
            if isinstance(layer, nn.Conv2d | nn.Linear) and layer.bias is not None:
                nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
                nn.init.zeros_(layer.bias)

    def forward(self, image: Tensor) -> Tensor:
        """Residual that the image shows.

        The output of Eq. 13 is sigmoid(c r) and line 20 of Algorithm 1 undoes it, so r itself is returned;
        `sigmoid_loss` applies the sigmoid.

        Parameters
        ----------
        image : tensor of shape (n, 2, 100, 100)
            Images of Eq. 9.

        Returns
        -------
        tensor of shape (n, 9)
            Residuals in units of the largest torque.
        """
        x = F.max_pool2d(F.relu(self.conv1(image)), 2)  # (n, 2, 100, 100) -> (n, 10, 92, 92) -> (n, 10, 46, 46)
        x = F.max_pool2d(F.relu(self.conv2(x)), 2)  # -> (n, 10, 42, 42) -> (n, 10, 21, 21)
        x = F.relu(self.conv3(x))  # -> (n, 10, 19, 19)
        x = F.relu(self.fc4(x.flatten(1)))  # (n, 3610) -> (n, 100)
        x = F.relu(self.fc5(x))  # -> (n, 50)
        residual: Tensor = self.fc6(x)  # -> (n, 9)
        return residual


def sigmoid_loss(residual: Tensor, label: Tensor, gain: float) -> Tensor:
    """Loss of Section IV-B: half the mean square difference of sigmoids.

    Parameters
    ----------
    residual, label : tensors of shape (n, 9)
        Residuals found and right.
    gain : float
        c of Eq. 13.

    Returns
    -------
    scalar tensor
        L = (1/18) sum_j (y_d,j - y_cnn,j)^2, averaged over the images.
    """
    return 0.5 * F.mse_loss(torch.sigmoid(gain * residual), torch.sigmoid(gain * label))
