"""Writes the modules that come from the contract, and copies the examples.

`signorini/v1/`: messages, stubs and their types, by protoc. `signorini/reports.py`: read-only
views of the messages of results, with the comments of the contract as documentation, so that
a new number of a report needs no word in Python. `signorini/scenes/`: the scenes of
`client/examples` with the meshes and surfaces that they name. Run by the build backend, and by hand for a
checkout that is used in place.
"""

import pathlib
import re
import shutil
import tempfile

import grpc_tools
from google.protobuf import descriptor_pb2
from grpc_tools import protoc

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parent / "signorini"
PROTO = HERE.parents[2] / "proto"
EXAMPLES = HERE.parents[1] / "examples"
SCENES = PACKAGE / "scenes"

# Messages that become views, by file.
VIEWED = {
    "signorini/v1/report.proto": None,
    "signorini/v1/session_service.proto": {"IterationStatistics"},
}

HEADER = '''"""What a result says. Written from the contract by build/generate.py: not to be edited.

Vectors are arrays, enumerations are words, what is absent is None.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from ._views import Vector, View, word

__all__ = {names}
'''


def main():
    """Generates everything."""
    files = sorted(path.relative_to(PROTO).as_posix() for path in (PROTO / "signorini/v1").glob("*.proto"))
    write_stubs(files)
    write_views(described(files))
    copy_scenes()


def includes():
    """Import paths of protoc."""
    own = pathlib.Path(grpc_tools.__file__).parent / "_proto"
    return [f"-I{PROTO}", f"-I{own}"]


def run(*arguments):
    """Runs protoc."""
    if protoc.main(["protoc", *includes(), *arguments]) != 0:
        raise SystemExit("protoc failed")


def write_stubs(files):
    """Messages, their types and the callers' side of the services."""
    out = PACKAGE.parent
    run(f"--python_out={out}", f"--pyi_out={out}", f"--grpc_python_out={out}", *files)
    (PACKAGE / "v1" / "__init__.py").write_text('"""The messages of the contract, as protoc makes them."""\n')


def described(files):
    """Descriptors of the files with their comments."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "set.binpb"
        run(f"--descriptor_set_out={out}", "--include_source_info", *files)
        return descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())


def write_views(descriptors):
    """One class a message."""
    classes = []
    for file in descriptors.file:
        if file.name not in VIEWED:
            continue
        notes = comments(file)
        for index, message in enumerate(file.message_type):
            chosen = VIEWED[file.name]
            if chosen is None or message.name in chosen:
                classes.append((message.name, view(message, notes, (4, index))))
    names = "[\n" + "".join(f'    "{name}",\n' for name, _ in classes) + "]"
    text = HEADER.format(names=names) + "".join(text for _, text in classes)
    (PACKAGE / "reports.py").write_text(text)


def comments(file):
    """Comments by path."""
    return {tuple(place.path): place.leading_comments for place in file.source_code_info.location}


def note(notes, path):
    """A comment as the text of a docstring."""
    text = " ".join(notes.get(path, "").split())
    return text.replace("\\", "\\\\").replace('"""', "'''")


def copy_scenes():
    """The examples of the command line; those of an earlier build are replaced."""
    for stale in SCENES.glob("*.toml"):
        stale.unlink()
    shutil.rmtree(SCENES / "meshes", ignore_errors=True)
    (SCENES / "meshes").mkdir(parents=True)
    for scene in sorted(EXAMPLES.glob("*.toml")):
        shutil.copy(scene, SCENES)
        for file in re.findall(r'\b(?:mesh|file) = "(meshes/[^"/]+)"', scene.read_text()):
            shutil.copy(EXAMPLES / file, SCENES / file)


def view(message, notes, path):
    """The class of one message."""
    lines = [f"\n\nclass {message.name}(View):", f'    """{note(notes, path) or message.name}"""', ""]
    maps = {nested.name: nested for nested in message.nested_type if nested.options.map_entry}
    for index, field in enumerate(message.field):
        kind, expression = access(field, maps)
        said = note(notes, (*path, 2, index))
        lines += ["    @cached_property", f"    def {field.name}(self) -> {kind}:"]
        lines += [f'        """{said}"""'] if said else []
        lines += [f"        return {expression}", ""]
    return "\n".join(lines).rstrip("\n") + "\n"


# Messages that every result has.
ALWAYS = {"residuals", "seconds", "unknowns", "report"}
# Vectors of three, one behind the other.
ROWS = {"points"}
SCALARS = {1: "float", 2: "float", 3: "int", 5: "int", 8: "bool", 9: "str"}
MESSAGE, ENUM, REPEATED = 11, 14, 3


def access(field, maps):
    """The type of a field and the expression that reads it."""
    value = f"self._message.{field.name}"
    kind = field.type_name.rsplit(".", 1)[-1]
    if kind in maps:
        held = maps[kind].field[1]
        if held.type != MESSAGE:
            return f"Mapping[str, {SCALARS[held.type]}]", f"dict({value})"
        entry = held.type_name.rsplit(".", 1)[-1]
        return f"Mapping[str, {entry}]", f"{{name: {entry}(one) for name, one in {value}.items()}}"
    if field.label == REPEATED:
        return repeated(field, kind, value)
    if field.type == ENUM:
        prefix = re.sub(r"(?<!^)(?=[A-Z])", "_", kind).upper() + "_"
        return "str | None", f'word(self._message, "{field.name}", "{prefix}")'
    present = f'self._message.HasField("{field.name}")'
    if field.type == MESSAGE and field.name in ALWAYS:
        return kind, f"{kind}({value})"
    if field.type == MESSAGE:
        return f"{kind} | None", f"{kind}({value}) if {present} else None"
    scalar = SCALARS[field.type]
    if field.proto3_optional:
        return f"{scalar} | None", f"{value} if {present} else None"
    return scalar, value


def repeated(field, kind, value):
    """As `access`, of a list."""
    if field.type == MESSAGE:
        return f"tuple[{kind}, ...]", f"tuple({kind}(one) for one in {value})"
    if SCALARS[field.type] == "float":
        rows = ".reshape(-1, 3)" if field.name in ROWS else ""
        return "Vector", f"self._vector({value}){rows}"
    return f"tuple[{SCALARS[field.type]}, ...]", f"tuple({value})"


if __name__ == "__main__":
    main()
