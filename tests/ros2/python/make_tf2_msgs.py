"""Makes the package tf2_msgs, which PyPI does not have, by ROS's own generators: make_tf2_msgs.py SCRATCH.

`rosidl` makes the sources from TFMessage.idl; a compiler makes the type support of rmw_fastrtps_cpp of them, into this environment.
"""

import importlib.metadata as metadata
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig

import numpy

HERE = pathlib.Path(__file__).parent
PREFIX = pathlib.Path(sys.prefix)
LIBRARIES = PREFIX / "lib"
PACKAGE = pathlib.Path(sysconfig.get_path("purelib")) / "tf2_msgs"

every = metadata.entry_points


class Once:
    """The wheels list each entry point twice, which `rosidl` refuses."""

    select = staticmethod(lambda **which: dict.fromkeys(every(**which)))


def generate(scratch):
    metadata.entry_points = Once
    os.environ["AMENT_PREFIX_PATH"] = str(PREFIX)
    os.chdir(HERE / "tf2_msgs")
    from rosidl_cli.cli import main

    kinds = ["-t", "c", "-t", "py", "-ts", "fastrtps_c", "-ts", "introspection_c", "-ts", "c"]
    sys.argv = ["rosidl", "generate", "-o", str(scratch), *kinds, "-I", str(PREFIX / "share"), "tf2_msgs", "msg/TFMessage.idl"]
    assert not main()


def compiled(compiler, sources, target, needed, include):
    include = [f"-I{folder}" for folder in [include, PREFIX / "include", *(PREFIX / "include").iterdir()]]
    include += [f"-I{sysconfig.get_path('include')}", f"-I{numpy.get_include()}"]
    linked = [f"-L{LIBRARIES}", f"-Wl,-rpath,{LIBRARIES}", *(f"-l{name}" for name in needed)]
    options = ["-O1", "-w", "-fPIC", "-shared", "-o", target]
    subprocess.run([compiler, *include, *sources, *options, *linked], check=True)


def main(scratch):
    shutil.rmtree(scratch, ignore_errors=True)
    generate(scratch)
    include = scratch / "include"
    # The sources of `introspection_c` have names that those of `c` have, too: they stay where they are.
    for kind in ["c", "fastrtps_c"]:
        shutil.copytree(scratch / kind, include / "tf2_msgs", dirs_exist_ok=True)
    for header in (scratch / "introspection_c").rglob("*.h"):
        shutil.copy(header, include / "tf2_msgs" / header.relative_to(scratch / "introspection_c"))
    messages = include / "tf2_msgs/msg"
    shutil.copytree(scratch / "py/msg", PACKAGE / "msg", dirs_exist_ok=True)
    (PACKAGE / "__init__.py").touch()

    def library(kind, compiler, sources, *needed):
        compiled(compiler, sources, LIBRARIES / f"libtf2_msgs__{kind}.so", needed, include)

    library(
        "rosidl_generator_c", "cc", sorted(messages.glob("detail/*.c")),
        "geometry_msgs__rosidl_generator_c", "rosidl_runtime_c", "rcutils",
    )  # fmt: skip
    library(
        "rosidl_typesupport_fastrtps_c", "c++", sorted(messages.glob("detail/*.cpp")),
        "tf2_msgs__rosidl_generator_c", "geometry_msgs__rosidl_typesupport_fastrtps_c",
        "rosidl_typesupport_fastrtps_c", "rosidl_typesupport_fastrtps_cpp", "fastcdr",
    )  # fmt: skip
    library(
        "rosidl_typesupport_introspection_c", "cc", sorted((scratch / "introspection_c").rglob("*.c")),
        "tf2_msgs__rosidl_generator_c", "geometry_msgs__rosidl_typesupport_introspection_c",
        "rosidl_typesupport_introspection_c",
    )  # fmt: skip
    library(
        "rosidl_typesupport_c", "c++", [messages / "tf_message__type_support.cpp"],
        "tf2_msgs__rosidl_generator_c", "tf2_msgs__rosidl_typesupport_fastrtps_c", "rosidl_typesupport_c",
    )  # fmt: skip
    library(
        "rosidl_generator_py", "cc", [scratch / "py/msg/_tf_message_s.c"],
        "tf2_msgs__rosidl_generator_c", "geometry_msgs__rosidl_generator_py",
    )  # fmt: skip
    for support in ["rosidl_typesupport_c", "rosidl_typesupport_fastrtps_c"]:
        needed = ["tf2_msgs__rosidl_generator_py", f"tf2_msgs__{support}", "tf2_msgs__rosidl_generator_c"]
        source = scratch / f"py/_tf2_msgs_s.ep.{support}.c"
        compiled("cc", [source], PACKAGE / f"tf2_msgs_s__{support}.so", needed, include)


main(pathlib.Path(sys.argv[1]))
