"""Scenes that come with the package, the examples of the command line; `signorini.example` names their files."""

from pathlib import Path

__all__ = ["example"]


def example(name: str) -> Path:
    """The file of a scene that comes with the package, such as `o-ring`."""
    there = {one.stem: one for one in sorted(Path(__file__).resolve().parent.glob("*.toml"))}
    if name not in there:
        raise FileNotFoundError(f'no example "{name}"; there are {", ".join(there)}')
    return there[name]
