"""A patch that could not be made, or wrinkles, goes in; cuts that were tried on it come out, the best first."""
