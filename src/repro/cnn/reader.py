"""The CNN for many guesses of one torque: all that the torque and the weights fix is computed once.

It computes what `repro.cnn.network.FactoredCNN` does with one `v` for all images, up to rounding, in another order:

- Bias and ReLU are one maximum: ReLU(x + b) = max(x, -b) + b. A valid convolution turns the shift b into a constant of
  its output, so it goes into the next layer's bias.
- The second convolution moves by two pixels and has a map for each of the four members of a pool, with the kernel at
  another place of a window one pixel larger. That is 1.44 times the products, but 40 maps fill the vector registers,
  which 10 do not, and the pool is two maxima of contiguous values.
- Layers 1 to 3 write into the same buffers for each piece of images: no page faults, and the values stay in a cache.
"""

import math

import torch
import torch.nn.functional as F  # noqa: N812  (torch's own convention)
from torch import Tensor, nn

from repro.cnn.network import FactoredCNN

#: Images at a time in layers 1 to 3: few enough for the cache, and enough to spread the cost of a call.
PIECE = 8


class Reader:
    """The network's inference for images that share the factor v (2, 2, S) of Eq. 9."""

    def __init__(self, network: FactoredCNN, v: Tensor) -> None:
        s = network.settings
        self._dtype, self._maps, self._kernel, self._side = network.dtype, s.maps, s.kernels[0], s.pooled[0]
        layers = network.conv1, network.conv2, network.conv3, network.fc4
        (w1, b1), (w2, b2), (w3, b3), (w4, b4) = (self._rounded(layer) for layer in layers)
        b2 = b2 + w2.sum((2, 3)) @ b1
        b3 = b3 + w3.sum((2, 3)) @ b2
        w4 = w4.view(len(w4), s.maps, s.pooled[2], s.pooled[2])
        b4 = b4 + w4.sum((2, 3)) @ b3
        # Rows (d, r, k), columns (parity of j, j, o): the product is channels last.
        t = torch.einsum("odkl,drjl->drkjo", w1, v.to(w1).unfold(-1, self._kernel, 1))
        t = t.reshape(-1, self._side, 2, s.maps).transpose(1, 2)
        members = [F.pad(w2, (j, 1 - j, i, 1 - i)) for i in (0, 1) for j in (0, 1)]
        self._t = self._cast(t.reshape(len(t), -1))
        self._w2 = self._cast(torch.cat(members)).contiguous(memory_format=torch.channels_last)
        self._w3 = self._cast(w3).contiguous(memory_format=torch.channels_last)
        self._w4 = self._cast(w4.permute(0, 2, 3, 1).reshape(len(w4), -1))
        self._b4 = self._cast(b4)
        self._floors = [self._cast(-b) for b in (b1.repeat(self._side), b2, b3)]
        self._rest = network.fc5, network.fc6
        sizes = (2 * len(t) * self._side, 4 * s.maps * self._side**2, s.maps * self._side**2)
        self._buffers = [torch.empty(PIECE * size, dtype=network.dtype) for size in sizes]

    def _rounded(self, layer: nn.Module) -> tuple[Tensor, Tensor]:
        """Weight and bias as layers 1 to 4 see them, in the dtype that constants are computed in."""
        weight, bias = (p.detach().to(self._dtype).to(p.dtype) for p in layer.parameters())
        return weight, bias

    def _cast(self, x: Tensor) -> Tensor:
        return x.to(self._dtype).contiguous()

    @torch.no_grad()
    def __call__(self, u: Tensor) -> Tensor:
        """Compute the residuals r (n, 9), in units of the largest torque, from the factors u (n, 2, 2, S)."""
        x = torch.empty(len(u), self._w4.shape[1], dtype=self._dtype)
        for k in range(0, len(u), PIECE):
            self._convolve(u[k : k + PIECE], x[k : k + PIECE])
        fc5, fc6 = self._rest
        x = F.relu_(F.linear(x, self._w4, self._b4)).to(fc5.weight.dtype)
        residual: Tensor = fc6(F.relu_(fc5(x)))
        return residual

    def _convolve(self, u: Tensor, out: Tensor) -> None:
        """Layers 1 to 3 of a piece."""
        n, side, maps = len(u), self._side, self._maps
        width = side * maps

        def buffer(which: int, *shape: int) -> Tensor:
            return self._buffers[which][: math.prod(shape)].view(shape)

        windows = u.unfold(-1, self._kernel, 1).view(n, 2, 2, side, 2, self._kernel)
        rows = buffer(0, 2, n, side, 2, 2, self._kernel)
        rows.copy_(windows.permute(4, 0, 3, 1, 2, 5))  # (parity of i, image, i, d, r, k)
        product = buffer(1, 2, n * side, 2, width)
        torch.mm(rows.view(2 * n * side, -1), self._t, out=product.view(2 * n * side, -1))
        torch.maximum(product[0], product[1], out=product[0])
        x = torch.maximum(product[0, :, 0], product[0, :, 1], out=buffer(2, n * side, width))
        torch.maximum(x, self._floors[0], out=x)
        y = F.conv2d(x.view(n, side, side, maps).permute(0, 3, 1, 2), self._w2, stride=2).permute(0, 2, 3, 1)
        y = torch.maximum(y[..., : 2 * maps], y[..., 2 * maps :])
        y = torch.maximum(y[..., :maps], y[..., maps:])
        torch.maximum(y, self._floors[1], out=y)
        z = F.conv2d(y.permute(0, 3, 1, 2), self._w3).permute(0, 2, 3, 1)
        torch.maximum(z, self._floors[2], out=out.view(z.shape))
