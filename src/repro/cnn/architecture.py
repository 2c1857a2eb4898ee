"""Sizes of the CNN of Fig. 7 and Table 3, and of its weights; the network itself is `repro.cnn.network`."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NetworkSettings:
    """Sizes of the network.

    Attributes
    ----------
    image_size : int
        Side of the input image.
    maps : int
        Output maps of each convolution.
    kernels : tuple of int
        Kernel sides of the three convolutions.
    hidden : tuple of int
        Widths of layers 4 and 5, which the paper's text does not give.
    sigmoid_gain : float
        c of Eq. 13.
    """

    image_size: int = 100
    maps: int = 10
    kernels: tuple[int, int, int] = (9, 5, 3)
    hidden: tuple[int, int] = (100, 50)
    sigmoid_gain: float = 1.0

    @property
    def pooled(self) -> tuple[int, int, int]:
        """Sides of the maps after layers 1, 2 and 3.

        Raises
        ------
        ValueError
            If an even side cannot be reached before a 2 x 2 pool, or nothing is left.
        """
        side = self.image_size
        sides = []
        for kernel, pool in zip(self.kernels, (2, 2, 1), strict=True):
            side = side - kernel + 1
            if side <= 0 or side % pool:
                raise ValueError(f"kernels {self.kernels}: leave a map of side {side}, which a pool of 2 does not fit.")
            side //= pool
            sides.append(side)
        return sides[0], sides[1], sides[2]

    @property
    def weights(self) -> dict[str, tuple[int, ...]]:
        """Shape of every weight by its name: kernels (output, input, k, k), matrices (output, input), biases.

        Raises
        ------
        ValueError
            As `pooled` does.
        """
        k1, k2, k3 = self.kernels
        maps, side = self.maps, self.pooled[2]
        weights: dict[str, tuple[int, ...]] = {
            "conv1": (maps, 2, k1, k1),
            "conv2": (maps, maps, k2, k2),
            "conv3": (maps, maps, k3, k3),
            "fc4": (self.hidden[0], maps * side * side),
            "fc5": (self.hidden[1], self.hidden[0]),
            "fc6": (9, self.hidden[1]),
        }
        shapes: dict[str, tuple[int, ...]] = {}
        for layer, shape in weights.items():
            shapes |= {f"{layer}.weight": shape, f"{layer}.bias": shape[:1]}
        return shapes
