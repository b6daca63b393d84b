"""One epoch of the Lorenz problem of Champion et al. 2019 in PyTorch: the shapes of lorenz.rs, random data (only time is asked)."""
import argparse, itertools, json, time
import torch
from torch import nn
ap = argparse.ArgumentParser(); ap.add_argument("--threads", type=int, default=2); a = ap.parse_args()
torch.set_num_threads(a.threads); torch.manual_seed(0)
N, W, Z, B = 256_000, [128, 64, 32, 3], 3, 1024
x, dx = torch.randn(N, W[0]), torch.randn(N, W[0])
terms = [c for d in range(1, 4) for c in itertools.combinations_with_replacement(range(Z), d)]
def theta(z): return torch.stack([torch.ones(len(z))] + [z[:, list(c)].prod(1) for c in terms], 1)
class Net(nn.Module):
    def __init__(s, widths):
        super().__init__(); s.layers = nn.ModuleList(nn.Linear(i, o) for i, o in zip(widths, widths[1:]))
    def forward(s, h, dh):
        for n, layer in enumerate(s.layers):
            h, dh = layer(h), dh @ layer.weight.T
            if n + 1 < len(s.layers): h = torch.sigmoid(h); dh = dh * h * (1 - h)
        return h, dh
enc, dec = Net(W), Net(W[::-1]); xi = nn.Parameter(torch.full((1 + len(terms), Z), .01))
opt = torch.optim.Adam([*enc.parameters(), *dec.parameters(), xi], 1e-3)
t = time.time()
for b in torch.randperm(N).split(B):
    z, dz = enc(x[b], dx[b]); p = theta(z) @ xi; xr, dxp = dec(z, p)
    loss = ((x[b] - xr) ** 2).mean() + .5 * ((dx[b] - dxp) ** 2).mean() + .01 * ((dz - p) ** 2).mean() + .01 * xi.abs().mean()
    opt.zero_grad(); loss.backward(); opt.step()
print(json.dumps(dict(seconds=round(time.time() - t, 3))))
