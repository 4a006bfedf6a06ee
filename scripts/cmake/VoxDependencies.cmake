# Every library of others that voxatlas uses, in one place; README.md gives each one's reason.
list(APPEND CMAKE_MODULE_PATH /usr/share/cmake/geographiclib)

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(tl-expected REQUIRED)
find_package(CLI11 REQUIRED)
find_package(octomap REQUIRED)
find_package(GeographicLib REQUIRED)
find_package(RocksDB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Catch2 2 REQUIRED)
find_package(benchmark REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PNG REQUIRED)

pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(JEMALLOC REQUIRED IMPORTED_TARGET jemalloc)
pkg_check_modules(ISAL REQUIRED IMPORTED_TARGET libisal)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(OSMESA REQUIRED IMPORTED_TARGET osmesa)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)

# Optional (scripts/setup --rados): the tile store in a Ceph cluster.
find_library(RADOS_LIBRARY rados)
find_path(RADOS_INCLUDE_DIR rados/librados.hpp)

# Debian's lcm.pc asks for glib-2.0's own .pc file, which liblcm-dev does not depend on.
find_library(LCM_LIBRARY lcm REQUIRED)
find_path(LCM_INCLUDE_DIR lcm/lcm.h REQUIRED)
find_program(LCM_GEN lcm-gen REQUIRED)
add_library(vox_lcm INTERFACE)
add_library(vox::lcm ALIAS vox_lcm)
set_target_properties(vox_lcm PROPERTIES EXPORT_NAME lcm)
target_include_directories(vox_lcm SYSTEM INTERFACE ${LCM_INCLUDE_DIR})
target_link_libraries(vox_lcm INTERFACE ${LCM_LIBRARY})

# Debian's octomap exports plain library paths; one target keeps its headers out of our warnings.
add_library(vox_octomap INTERFACE)
add_library(vox::octomap ALIAS vox_octomap)
set_target_properties(vox_octomap PROPERTIES EXPORT_NAME octomap)
target_include_directories(vox_octomap SYSTEM INTERFACE ${OCTOMAP_INCLUDE_DIRS})
target_link_libraries(vox_octomap INTERFACE ${OCTOMAP_LIBRARIES})

add_library(vox_geographic INTERFACE)
add_library(vox::geographic ALIAS vox_geographic)
set_target_properties(vox_geographic PROPERTIES EXPORT_NAME geographic)
target_include_directories(vox_geographic SYSTEM INTERFACE ${GeographicLib_INCLUDE_DIRS})
target_link_libraries(vox_geographic INTERFACE ${GeographicLib_LIBRARIES})
