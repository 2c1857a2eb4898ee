"""Lines 17 to 21 of Algorithm 1 for many guesses at once: guess -> image -> CNN -> residual -> estimate."""

import numpy as np
import torch

from repro.cnn.image import ImageSettings, image_factors
from repro.cnn.network import FactoredCNN
from repro.identification.algorithm1.listing import Prepared
from repro.model.parameters import Array


class ResidualReader:
    """The trained network looking at one torque.

    Parameters
    ----------
    network : FactoredCNN
        Trained network.
    image : ImageSettings
        Divisors of Eq. 9, those the network was trained with.
    prepared : Prepared
        Signals of the arm.
    batch : int
        Images at a time.
    """

    def __init__(self, network: FactoredCNN, image: ImageSettings, prepared: Prepared, batch: int = 100) -> None:
        self._network = network
        self._image = image
        self._alpha = prepared.alpha.astype(np.float32)
        self._model = prepared.model.reshape(-1, 9).T
        self._batch = batch
        #: Images read so far.
        self.images = 0

    def estimate(self, guess: Array) -> Array:
        """Estimates beta = r + beta_n (lines 18 to 21).

        Parameters
        ----------
        guess : array of shape (n, 9)
            Guesses beta_n in units of the largest torque.

        Returns
        -------
        array of shape (n, 9)
            Estimates in the same unit.
        """
        parts = [self._residual(guess[k : k + self._batch]) for k in range(0, len(guess), self._batch)]
        self.images += len(guess)
        return guess + np.concatenate(parts) if parts else guess

    def _residual(self, guess: Array) -> Array:
        psi = 2 * self._alpha - (guess @ self._model).reshape(-1, *self._alpha.shape).astype(np.float32)
        u, v = image_factors(np.broadcast_to(self._alpha, psi.shape), psi, self._image)
        with torch.no_grad():
            # Lines 19 and 20: the sigmoid of the output layer and its inverse cancel.
            residual: torch.Tensor = self._network(torch.from_numpy(u), torch.from_numpy(v[:1].copy()))
        return residual.numpy().astype(np.float64)
