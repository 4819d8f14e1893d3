"""The curve network: curves sampled once, faces traced, patches with boundaries ready to be fitted.

What makes it is not imported here: the processes that fit its patches do without.
"""

from flatnet.network.network import CurveNetwork, SampledStretch
from flatnet.network.patch import BoundaryCurve, Patch, Stretch

__all__ = ["BoundaryCurve", "CurveNetwork", "Patch", "SampledStretch", "Stretch"]
