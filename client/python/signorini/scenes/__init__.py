"""Scenes that come with the package; `signorini.example` names their files."""

from pathlib import Path

__all__ = ["example"]


def example(name: str) -> Path:
    """The file of a scene that comes with the package, such as `o-ring`."""
    folder = Path(__file__).resolve().parent
    path = folder / f"{name}.toml"
    if not path.is_file():
        there = ", ".join(sorted(one.stem for one in folder.glob("*.toml")))
        raise FileNotFoundError(f'no example "{name}"; there are {there}')
    return path
