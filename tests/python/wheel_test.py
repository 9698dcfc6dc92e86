"""The wheel: built from the tree over an installed library, unpacked, and used with nothing else: wheel_test.py PREFIX."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

MISSING = [name for name in ("cffi", "numpy", "pip", "setuptools", "wheel") if importlib.util.find_spec(name) is None]
if MISSING:
    print(f"skipped: no {', '.join(MISSING)} (Debian: {' '.join('python3-' + name for name in MISSING)})")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[2]
PREFIX = sys.argv.pop()


class Wheel(unittest.TestCase):
    def test_it_holds_all_that_the_package_needs(self):
        with tempfile.TemporaryDirectory() as folder:
            options = ["--no-build-isolation", "--no-deps", "--no-index", "--quiet", "--wheel-dir", folder]
            line = [sys.executable, "-m", "pip", "wheel", *options, str(ROOT)]
            subprocess.run(line, check=True, env=os.environ | {"DVDX_PREFIX": PREFIX})
            (built,) = pathlib.Path(folder).glob("*.whl")
            self.assertRegex(built.name, r"^dvdx-\d+\.\d+\.\d+-py3-none-.*\.whl$")
            with zipfile.ZipFile(built) as archive:
                names = set(archive.namelist())
                archive.extractall(f"{folder}/unpacked")
            headers = ("include/dvdx/dvdx.h", "include/dvdx/c/scene.h", "include/dvdx/version.h")
            for name in ("__init__.py", "py.typed", *headers, "lib/libdvdx.so"):
                self.assertIn(f"dvdx/{name}", names)
            environment = {name: value for name, value in os.environ.items() if not name.startswith("DVDX_")}
            (block,) = re.findall(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(), re.DOTALL | re.MULTILINE)
            script = block + f"assert dvdx.__file__.startswith({folder!r}) and np.any(velocities)\nhelp(dvdx.Scene)\n"
            told = subprocess.run(
                [sys.executable, "-B", "-c", script], check=True, env=environment | {"PYTHONPATH": f"{folder}/unpacked"},
                stdout=subprocess.PIPE, text=True, cwd=folder,
            )  # fmt: skip
            self.assertIn("acceleration", told.stdout)


if __name__ == "__main__":
    unittest.main()
