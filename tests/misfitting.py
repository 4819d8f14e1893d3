"""A `fit` for `flatnet.build` that misbehaves on request."""

from misbehaving import DEEDS

from flatnet.fitting.run import run_patch


def fit(patch, parameters):
    """`run_patch`, but patches called after a deed do it."""
    if patch.name in DEEDS:
        DEEDS[patch.name]()
    return run_patch(patch, parameters)
