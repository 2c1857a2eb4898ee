"""The CNN of Fig. 7 and Table 3, evaluated on the factors of its images, so that no image is built.

For a channel Z[d] = sum_r u[d,r] v[d,r]^T the first convolution is

    (W * Z)[o, i, j] = sum_{d,r,k} u[d,r,i+k] T[(d,r,k), (o,j)],   T[(d,r,k), (o,j)] = sum_l W[o,d,k,l] v[d,r,j+l],

one (92 x 36) (36 x 460) product for each parity of j, with the rows sorted by the parity of i. The four blocks are
the four members of each 2 x 2 pool, so pooling is three elementwise maxima, and bias and ReLU, which keep the order,
come after it on a quarter of the data.
"""

from pathlib import Path
from typing import Any, get_args

import numpy as np
import torch
import torch.nn.functional as F  # noqa: N812  (torch's own convention)
from numpy.typing import ArrayLike, NDArray
from torch import Tensor, nn

from repro.cnn.architecture import NetworkSettings, Precision, read_weights
from repro.errors import InputError
from repro.files import write_tensors

#: Images at a time in layer 1 without gradients: the values between product and pool then fit into a cache.
PIECE = 16


def sigmoid_loss(residual: Tensor, label: Tensor, gain: float) -> Tensor:
    """Compute L = (1/18) sum_j (y_d,j - y_cnn,j)^2 of Section IV-B, y = sigmoid(gain x), averaged over (n, 9)."""
    return 0.5 * F.mse_loss(torch.sigmoid(gain * residual), torch.sigmoid(gain * label))


def on_this_processor(precision: Precision) -> Precision:
    """Resolve ``auto``: bfloat16 if the processor multiplies it natively, else float32, which is then much faster."""
    if precision != "auto":
        return precision
    able = torch.cpu.get_capabilities()
    has_bfloat16 = any(able.get(name) for name in ("avx512_bf16", "amx_bf16", "bf16"))
    # A build without oneDNN only emulates bfloat16, and ONEDNN_MAX_CPU_ISA may limit oneDNN to do so too.
    has_onednn = torch.backends.mkldnn.is_available()  # type: ignore[no-untyped-call]
    has_bfloat16 = has_bfloat16 and has_onednn and torch.ops.mkldnn._is_mkldnn_bf16_supported()
    return "bfloat16" if has_bfloat16 else "float32"


def _windows(x: Tensor, kernel: int) -> Tensor:
    """Split sliding windows by the parity of their start: (..., S) -> (..., S'/2, parity, kernel)."""
    w = x.unfold(-1, kernel, 1)
    return w.view(*w.shape[:-2], w.shape[-2] // 2, 2, kernel)


class _FirstLayer(torch.autograd.Function):
    """ReLU(bias + maxpool2(conv(Z))) with gradients for weight and bias; without gradients one `v` may do for all u."""

    @staticmethod
    def forward(ctx: Any, u: Tensor, v: Tensor, weight: Tensor, bias: Tensor) -> Tensor:  # noqa: ANN401
        n, d, r, _ = u.shape
        maps, _, k, _ = weight.shape
        rows = _windows(u, k).permute(0, 4, 3, 1, 2, 5)  # (n, parity, i, d, r, k)
        half = rows.shape[2]
        rows = rows.reshape(n, 2 * half, d * r * k)
        m = len(v)  # n or 1
        columns = _windows(v, k).permute(4, 0, 1, 2, 5, 3).reshape(2, m * d * r, k, half)  # (parity, (m d r), l, j)
        kernel = weight.permute(1, 2, 0, 3).reshape(1, d, 1, k * maps, k)  # (1, d, 1, (k o), l)
        kernel = kernel.expand(m, d, r, k * maps, k).reshape(m * d * r, k * maps, k)
        # (m, (d r k), (o j)) each, without m where it is 1: one product for all images
        t = [torch.bmm(kernel, c).view(m, d * r * k, maps * half).squeeze(0) for c in columns]
        members = [torch.matmul(rows, x).view(n, 2, half, maps * half) for x in t]  # (n, parity, i, (o j)) each
        pooled = torch.maximum(members[0][:, 0], members[0][:, 1])
        for x in (members[1][:, 0], members[1][:, 1]):
            torch.maximum(pooled, x, out=pooled)
        biases = bias.repeat_interleave(half)
        if not any(ctx.needs_input_grad):
            return pooled.add_(biases).relu_().view(n, half, maps, half).permute(0, 2, 1, 3)
        out = F.relu_(pooled + biases).view(n, half, maps, half)
        ctx.save_for_backward(rows, columns, pooled, out, *members)
        ctx.shape = (d, r, k, maps)
        return out.permute(0, 2, 1, 3)  # (n, maps, half, half)

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> tuple[None, None, Tensor, Tensor]:  # noqa: ANN401
        rows, columns, pooled, out, *members = ctx.saved_tensors
        d, r, k, maps = ctx.shape
        n, half, _ = pooled.shape
        wide = torch.promote_types(rows.dtype, torch.float32)  # bfloat16 is too coarse for sums over the batch
        grad = grads[0].permute(0, 2, 1, 3).contiguous()  # (n, i, o, j)
        grad = torch.ops.aten.threshold_backward(grad, out, 0)
        grad_bias = grad.sum((1, 3), dtype=wide).sum(0)
        for x in members:
            x.eq_(pooled[:, None])
        # Neighbouring pixels often tie in bfloat16: the winners of a pool share its gradient.
        winners = torch.add(members[0][:, 0], members[0][:, 1])
        winners.add_(members[1][:, 0]).add_(members[1][:, 1])
        grad = grad.view(n, half, maps * half).div_(winners)
        grad_weight = torch.zeros(d, r, k * maps * k, dtype=wide)
        for x, c in zip(members, columns, strict=True):
            g = torch.bmm(rows.mT, x.mul_(grad[:, None]).view(n, 2 * half, -1))  # (n, (d r k), (o j))
            w = torch.bmm(g.view(n * d * r, k * maps, half), c.mT)  # ((n d r), (k o), l)
            grad_weight += w.view(n, d, r, -1).sum(0, dtype=wide)
        weight = grad_weight.sum(1).view(d, k, maps, k).permute(2, 0, 1, 3)
        return None, None, weight.to(rows.dtype), grad_bias.to(rows.dtype)


def _members(x: Tensor) -> list[Tensor]:
    """Return the four members of every 2 x 2 window, (n, c, h, w) -> four of (n, c, h/2, w/2)."""
    return [x[:, :, i::2, j::2] for i in (0, 1) for j in (0, 1)]


class _MaxPool2(torch.autograd.Function):
    """2 x 2 max pool as two elementwise maxima: four times faster than the library's on channels-last maps."""

    @staticmethod
    def forward(ctx: Any, x: Tensor) -> Tensor:  # noqa: ANN401
        rows = torch.maximum(x[:, :, ::2], x[:, :, 1::2])
        pooled = torch.maximum(rows[..., ::2], rows[..., 1::2])
        ctx.save_for_backward(x, pooled)
        return pooled

    @staticmethod
    def backward(ctx: Any, *grads: Tensor) -> Tensor:  # noqa: ANN401
        x, pooled = ctx.saved_tensors
        won = [torch.empty_like(pooled).copy_(member).eq_(pooled) for member in _members(x)]
        share = grads[0] / torch.add(won[0], won[1]).add_(won[2]).add_(won[3])  # winners of a tie share
        grad = torch.empty_like(x)
        for winner, member in zip(won, _members(grad), strict=True):
            member.copy_(winner.mul_(share))
        return grad


class FactoredCNN(nn.Module):
    """Convolution 9-pool-5-pool-3, then three fully connected layers.

    Layers 1 to 4 compute in `precision`. Weights and layers 5 and 6 stay in the weights' own dtype.
    """

    def __init__(self, settings: NetworkSettings, precision: str = "float32") -> None:
        super().__init__()
        self.settings = settings
        self.dtype: torch.dtype = getattr(torch, precision)
        (k1, k2, k3), maps, (first, second) = settings.kernels, settings.maps, settings.hidden
        self.conv1 = nn.Conv2d(2, maps, k1)
        self.conv2 = nn.Conv2d(maps, maps, k2)
        self.conv3 = nn.Conv2d(maps, maps, k3)
        self.fc4 = nn.Linear(maps * settings.pooled[2] ** 2, first)
        self.fc5 = nn.Linear(first, second)
        self.fc6 = nn.Linear(second, 9)
        for layer in self.children():  # keeps the variance of activations through ReLU layers
            weight, bias = layer.parameters()
            nn.init.kaiming_normal_(weight, nonlinearity="relu")
            nn.init.zeros_(bias)

    def _cast(self, layer: nn.Module) -> tuple[Tensor, Tensor]:
        """Return weight, channels last if it is a kernel, and bias in the dtype of layers 1 to 4."""
        weight, bias = layer.parameters()
        form = torch.channels_last if weight.ndim == 4 else torch.contiguous_format
        return weight.to(self.dtype, memory_format=form), bias.to(self.dtype)

    def forward(self, u: Tensor, v: Tensor) -> Tensor:
        """Compute the residuals r (n, 9), in units of the largest torque, from factors of Eq. 9 (`image_factors`).

        u is (n, 2, 2, 100). So is v, or (1, 2, 2, 100) if all images share it, which only works while layer 1 does not
        learn. Line 20 of Algorithm 1 undoes the output sigmoid(c r) of Eq. 13, so only `sigmoid_loss` applies it.
        """
        weight, bias = self._cast(self.conv1)
        u, v = u.to(self.dtype), v.to(self.dtype)
        form = torch.channels_last  # the fastest layout for the second convolution
        if weight.requires_grad or bias.requires_grad:
            x: Tensor = _FirstLayer.apply(u, v, weight, bias)  # type: ignore[no-untyped-call]
            x = x.contiguous(memory_format=form)  # (n, 10, 46, 46)
        else:
            side = self.settings.pooled[0]
            x = torch.empty(len(u), self.settings.maps, side, side, dtype=self.dtype, memory_format=form)
            for k in range(0, len(u), PIECE):
                piece = slice(k, k + PIECE)
                columns = v[piece] if len(v) > 1 else v
                x[piece] = _FirstLayer.apply(u[piece], columns, weight, bias)  # type: ignore[no-untyped-call]
        # ReLU after the pool: the same function on a quarter of the data.
        x = F.conv2d(x, *self._cast(self.conv2))  # -> (n, 10, 42, 42)
        x = _MaxPool2.apply(x)  # type: ignore[no-untyped-call]
        x = F.relu(x)  # -> (n, 10, 21, 21)
        x = F.conv2d(x, *self._cast(self.conv3))  # -> (n, 10, 19, 19)
        x = F.linear(F.relu_(x.flatten(1)), *self._cast(self.fc4))  # (n, 3610) -> (n, 100)
        x = F.relu(self.fc5(F.relu(x.to(self.fc5.weight.dtype))))  # -> (n, 50)
        residual: Tensor = self.fc6(x)  # -> (n, 9)
        return residual


def save_network(path: Path, network: nn.Module, metadata: dict[str, str]) -> None:
    """Write the weights as safetensors; the header takes one fact, since several would be written in any order."""
    write_tensors(path, {name: weight.numpy() for name, weight in network.state_dict().items()}, metadata)


def load_network(
    path: str | Path, settings: NetworkSettings | None = None, fact: str | None = None, precision: Precision = "float32"
) -> FactoredCNN:
    """Read the weights into a network for inference.

    Parameters
    ----------
    path : path
        Safetensors file, such as those in ``data/networks``.
    settings : NetworkSettings
        Sizes, not public: leave it out for the paper's, which all files in ``data/networks`` have.
    fact : str, optional
        What the file's header must state, such as the name of the network.
    precision : {"auto", "float32", "bfloat16"}
        Arithmetic of layers 1 to 4.

    Returns
    -------
    FactoredCNN
        Without gradients.

    Raises
    ------
    InputError
        If the file is missing or damaged, or has another network or other sizes, or `precision` is not one of these.

    Examples
    --------
    >>> network = repro.load_network("data/networks/cnn.safetensors")
    >>> sum(weight.numel() for weight in network.parameters())
    371659
    """
    settings = settings or NetworkSettings()
    if precision not in get_args(Precision):
        raise InputError.at("precision", repr(precision), f"one of {', '.join(get_args(Precision))}")
    weights = read_weights(Path(path), settings, fact)
    network = FactoredCNN(settings, on_this_processor(precision))
    network.load_state_dict({name: torch.from_numpy(weight) for name, weight in weights.items()})
    return network.requires_grad_(False)


def estimate_residuals(network: FactoredCNN, images: ArrayLike) -> NDArray[np.float32]:
    """Estimate from images how far their guesses are from the parameters (lines 19 and 20 of Algorithm 1).

    A guess plus its residual is the corrected guess (line 21). A search with many guesses of one torque needs no images
    and is faster (`algorithm1`).

    Parameters
    ----------
    network : FactoredCNN
        Trained for the motion of the images, see `load_network`.
    images : array_like of shape (..., 2, 100, 100)
        Of guesses, see `images`.

    Returns
    -------
    array of shape (..., 9)
        Residuals in units of the largest torque, in float32.

    Raises
    ------
    ValueError
        If the shape is wrong or a value is not finite.

    Examples
    --------
    >>> t = np.linspace(0.0, 9.4, 100)
    >>> q = np.stack([np.sin(t), np.sin(2.5 * t)])
    >>> guesses = np.full((3, 9), 0.5)
    >>> network = repro.load_network("data/networks/cnn.safetensors")
    >>> residuals = repro.estimate_residuals(network, repro.images(q, 0 * q, 0 * q, np.cos(q), guesses))
    >>> (guesses + residuals).shape
    (3, 9)
    """
    z = np.asarray(images, np.float32)
    shape = (2, network.settings.image_size, network.settings.image_size)
    if z.shape[-3:] != shape or not np.isfinite(z).all():
        raise ValueError(f"images: expected finite values of shape (..., {', '.join(map(str, shape))}), got {z.shape}.")
    with torch.inference_mode():
        x = torch.from_numpy(z.reshape(-1, *shape))
        x = F.relu(F.max_pool2d(network.conv1(x), 2))
        x = F.relu(F.max_pool2d(network.conv2(x), 2))
        x = F.relu(network.conv3(x)).flatten(1)
        x = network.fc6(F.relu(network.fc5(F.relu(network.fc4(x)))))
    return np.asarray(x.numpy().reshape(*z.shape[:-3], 9))
