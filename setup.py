"""Puts the library and its header into the Python package: built by CMake, or taken from DVDX_PREFIX where it is installed.

DVDX_CMAKE_ARGS are more options of CMake. The wheel has the instruction sets of this machine alone, which is soon built;
DVDX_CMAKE_ARGS=-DDVDX_ISAS=all makes one for others as well.
"""

import os
import pathlib
import platform
import re
import shutil
import subprocess

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

ROOT = pathlib.Path(__file__).resolve().parent
BUILD = ROOT / "build/wheel"


def version():
    return re.search(r"project\(dvdx VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]


def instruction_sets():
    """The best one that this machine has."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return "one"
    flags = pathlib.Path("/proc/cpuinfo")
    flags = set(flags.read_text().split()) if flags.exists() else set()
    if {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= flags:
        return "avx512"
    return "avx2" if "avx2" in flags else "sse2"


def built():
    """The prefix of a library that was built here."""
    options = [f"-DDVDX_{name}=OFF" for name in ("BUILD_TOOLS", "BUILD_TESTS", "BUILD_BENCH", "MPI")]
    options += ["-DCMAKE_BUILD_TYPE=Release", f"-DDVDX_ISAS={instruction_sets()}"]
    options += ["-G", "Ninja"] if shutil.which("ninja") else []
    options += os.environ.get("DVDX_CMAKE_ARGS", "").split()
    subprocess.run(["cmake", "-S", str(ROOT), "-B", str(BUILD), *options], check=True)
    threads = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL") or str(os.cpu_count())
    subprocess.run(["cmake", "--build", str(BUILD), "--parallel", threads, "--target", "dvdx_installed"], check=True)
    for component in ("library", "development"):
        line = ["cmake", "--install", str(BUILD), "--component", component, "--prefix", str(BUILD / "prefix")]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL)
    return BUILD / "prefix"


class BuildWithLibrary(build_py):
    def run(self):
        super().run()
        prefix = pathlib.Path(os.environ.get("DVDX_PREFIX") or built())
        libraries = [*prefix.glob("lib*/libdvdx*.so"), *prefix.glob("lib/*/libdvdx*.so")]
        include = prefix / "include/dvdx"
        headers = [include / "dvdx.h", include / "version.h"]
        if not libraries:
            raise RuntimeError(f"no libdvdx.so under {prefix}")
        for files, folder in ((headers, "include/dvdx"), ([*include.glob("c/*.h")], "include/dvdx/c"), (libraries, "lib")):
            target = pathlib.Path(self.build_lib, "dvdx", folder)
            target.mkdir(parents=True, exist_ok=True)
            for file in files:
                shutil.copyfile(file, target / file.name)


class PlatformWheel(bdist_wheel):
    """For any Python 3 of this platform: the library is loaded, not linked."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class PlatformDistribution(Distribution):
    def has_ext_modules(self):
        return True


(ROOT / "build").mkdir(exist_ok=True)
setup(
    version=version(),
    distclass=PlatformDistribution,
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel},
    options={"build": {"build_base": "build/wheel-files"}, "egg_info": {"egg_base": "build"}},
)
