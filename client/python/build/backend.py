"""Build backend: the modules of the contract are generated, then maturin does the rest.

Wheels only, from a checkout of the repository: the program needs all of it. With the setting
`portable` (`pip wheel --config-settings portable=yes`) zig links, and the wheel fits every Linux
from glibc 2.28 on; without, those at least as new as this.
"""

import generate
from maturin import build_wheel as _build_wheel
from maturin import get_requires_for_build_wheel as _requires
from maturin import prepare_metadata_for_build_wheel

__all__ = ["build_wheel", "get_requires_for_build_wheel", "prepare_metadata_for_build_wheel"]

PORTABLE = "--zig --compatibility manylinux_2_28"


def is_portable(config_settings):
    """Whether the wheel is for other machines than this."""
    return (config_settings or {}).get("portable", "no") == "yes"


def get_requires_for_build_wheel(config_settings=None):
    """What maturin needs, and zig for portable wheels."""
    zig = ["ziglang"] if is_portable(config_settings) else []
    return [*_requires(config_settings), *zig]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds a wheel with generated modules."""
    generate.main()
    settings = dict(config_settings or {})
    if is_portable(settings):
        del settings["portable"]
        settings["build-args"] = f"{settings.get('build-args', '')} {PORTABLE}".strip()
    return _build_wheel(wheel_directory, settings, metadata_directory)
