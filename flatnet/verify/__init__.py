"""Check a build from its written files alone: `verify` reads them with readers and formulas of its own."""

from flatnet.verify.certificate import Certificate
from flatnet.verify.verify import verify
from flatnet.verify.written import NotABuildError

__all__ = ["Certificate", "NotABuildError", "verify"]
