#!/usr/bin/env python3
"""What is installed works where it lies: the demo, and clients that know only the prefix."""

import os
import re
import subprocess

from support import harness

from service_set import default_bin_dir

BUILD = default_bin_dir().parent
PREFIX_VARIABLES = ("VOX_BIN_DIR", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE")

# What a client of the libraries does: a place, its tile, a tile's bytes and back, a bus.
LIBS_CLIENT = r'''
#include <cstdio>

#include "bus/bus.hpp"
#include "codec/tile_codec.hpp"
#include "grid/tile_key.hpp"

int main() {
  using namespace voxatlas;
  TileTree tile;
  tile.hit(CellKey::of_voxel({1, 2, 3}, 7), SensorModel::standard());
  const auto back = decode_tile(encode_tile(tile, {TileCodec::kDense}));
  const auto bus = Bus::create("memq://");
  std::printf("%s %s\n", back && *back == tile ? "same" : "other", bus ? "bus" : "no bus");
}
'''
LIBS_CMAKE = """
cmake_minimum_required(VERSION 3.25)
project(client CXX)
find_package(voxatlas REQUIRED COMPONENTS libs)
add_executable(client client.cpp)
target_link_libraries(client voxatlas::codec voxatlas::bus)
"""


class Install(harness.SystemTest):
    @classmethod
    def setUpClass(cls):
        cls.prefix = harness.temporary_folder(cls)
        for component in ("services", "types", "libs"):
            subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.prefix, "--component",
                            component], check=True, stdout=subprocess.DEVNULL)
        cls.env = {k: v for k, v in os.environ.items() if k not in PREFIX_VARIABLES}
        cls.env["CMAKE_PREFIX_PATH"] = str(cls.prefix)
        cls.readme = (harness.ROOT / "README.md").read_text(encoding="utf-8")

    def text_of(self, kind, after):
        """The first block of this kind behind a sentence of README."""
        rest = self.readme[self.readme.index(after):]
        return re.search(rf"^```{kind}\n(.*?)^```$", rest, re.M | re.S).group(1)

    def build(self, cmake, **sources):
        (self.folder / "CMakeLists.txt").write_text(cmake)
        for name, text in sources.items():
            (self.folder / f"{name}.cpp").write_text(text)
        for step in (["-S", self.folder, "-B", self.folder / "build"],
                     ["--build", self.folder / "build"]):
            done = subprocess.run(["cmake", *step], env=self.env, capture_output=True, text=True,
                                  check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_demo_runs_from_the_installed_files_alone(self):
        done = subprocess.run([self.prefix / "bin" / "voxatlas-demo", "--scans", "3", "--size",
                               "320x180"], cwd=self.folder, env=self.env, text=True,
                              capture_output=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("nothing was lost", done.stdout)
        self.assertNotIn("build:", done.stdout)
        self.assertTrue((self.folder / "voxatlas-demo" / "street.png").exists())

    def test_the_readmes_project_builds_against_the_cmake_package(self):
        self.build(self.text_of("cmake", "A client's `CMakeLists.txt`"),
                   logger=self.text_of("cpp", "`logger.cpp` publishes"),
                   subscriber=self.text_of("cpp", "`subscriber.cpp` hears"))
        self.assertTrue((self.folder / "build" / "logger").exists())

    def test_pkg_config_says_all_that_the_readmes_logger_needs(self):
        (self.folder / "logger.cpp").write_text(self.text_of("cpp", "`logger.cpp` publishes"))
        pkgconfig = next(self.prefix.glob("lib/**/pkgconfig"))
        env = {**self.env, "PKG_CONFIG_PATH": str(pkgconfig)}
        flags = subprocess.run(["pkg-config", "--cflags", "--libs", "voxatlas"], env=env,
                               check=True, capture_output=True, text=True).stdout.split()
        self.assertIn("-fno-strict-aliasing", flags)
        subprocess.run(["g++", "-std=c++17", self.folder / "logger.cpp", "-o",
                        self.folder / "logger", *flags], check=True)

    def test_a_client_of_the_libraries_builds_and_runs(self):
        self.build(LIBS_CMAKE, client=LIBS_CLIENT)
        said = subprocess.run([self.folder / "build" / "client"], check=True, capture_output=True,
                              text=True).stdout
        self.assertEqual(said, "same bus\n")

    def test_nothing_of_the_source_tree_is_named_in_what_is_installed(self):
        # At the beginning of a path alone: in /voxatlas, PREFIX/include/voxatlas is none of it.
        root = re.compile(rb"(?:-[IL]|(?<![\w.})/-]))" + re.escape(str(harness.ROOT).encode()) +
                          rb"(?![\w.-])")
        self.assertTrue(root.search(f"-I{harness.ROOT}/libs".encode()))
        named = [path for path in self.prefix.glob("lib/**/*")
                 if path.suffix in (".cmake", ".pc", ".hpp") and root.search(path.read_bytes())]
        self.assertEqual(named, [])


if __name__ == "__main__":
    harness.main()
