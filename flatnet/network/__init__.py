"""The curve network: curves sampled once, faces traced, patches with boundaries ready to be fitted."""

from flatnet.network.assembly import make_network
from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch

__all__ = ["BoundaryCurve", "CurveNetwork", "Patch", "SampledStretch", "Stretch", "make_network"]
