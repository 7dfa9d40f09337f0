"""Build backend: the modules of the contract are generated, then maturin does the rest.

Wheels only, from a checkout of the repository: the program needs all of it.
"""

import generate
from maturin import build_wheel as _build_wheel
from maturin import get_requires_for_build_wheel, prepare_metadata_for_build_wheel

__all__ = ["build_wheel", "get_requires_for_build_wheel", "prepare_metadata_for_build_wheel"]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds a wheel with generated modules."""
    generate.main()
    return _build_wheel(wheel_directory, config_settings, metadata_directory)
