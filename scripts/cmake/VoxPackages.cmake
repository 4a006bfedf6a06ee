# Debian packages of the four components of VoxInstall.cmake: scripts/package calls CPack.
#
#   voxatlas         services; what they load is found out by dpkg-shlibdeps
#   voxatlas-rados   rados: brings librados; voxatlas recommends it
#   voxatlas-types   types
#   voxatlas-dev     libs
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "voxatlas <voxatlas@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "probabilistic voxel model of the whole Earth, over LCM")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_ALL services types libs)
set(CPACK_STRIP_FILES ON)
# Tests and benches are in no package: what is needed was built by target.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)

set(CPACK_DEBIAN_SERVICES_PACKAGE_NAME voxatlas)
set(CPACK_DEBIAN_SERVICES_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVICES_PACKAGE_DEPENDS "python3, iproute2, util-linux, passwd")
set(CPACK_DEBIAN_SERVICES_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/scripts/systemd/postinst)

if(TARGET vox_rados_module)
  list(APPEND CPACK_COMPONENTS_ALL rados)
  set(CPACK_DEBIAN_SERVICES_PACKAGE_RECOMMENDS voxatlas-rados)
  set(CPACK_DEBIAN_RADOS_PACKAGE_NAME voxatlas-rados)
  set(CPACK_DEBIAN_RADOS_PACKAGE_SHLIBDEPS ON)
  # The module takes what it needs from the programs: they must be of the same build.
  set(CPACK_DEBIAN_RADOS_PACKAGE_DEPENDS "voxatlas (= ${PROJECT_VERSION})")
endif()

set(CPACK_DEBIAN_TYPES_PACKAGE_NAME voxatlas-types)
set(CPACK_DEBIAN_TYPES_PACKAGE_DEPENDS "liblcm-dev, liblcm-bin")

set(CPACK_DEBIAN_LIBS_PACKAGE_NAME voxatlas-dev)
set(CPACK_COMPONENT_LIBS_DEPENDS types)
set(CPACK_DEBIAN_LIBS_PACKAGE_DEPENDS
    "libeigen3-dev, libfmt-dev, libexpected-dev, libssl-dev, libzstd-dev, libisal-dev, libhwy-dev, liboctomap-dev, libgeographiclib-dev, pkg-config")
include(CPack)
