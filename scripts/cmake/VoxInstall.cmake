# What `cmake --install` puts where, in four components; VoxPackages.cmake makes a Debian package of
# each. Paths are relative to the prefix (/usr in the packages).
#
#   services   the programs, voxatlas-up and voxatlas-demo, systemd's units
#   rados      the module for models in a Ceph cluster, where scripts/setup --rados has been run
#   types      for clients in any language: the .lcm files; for C++ what lcm-gen made of them, with
#              a pkg-config file and a CMake package (voxatlas::lcmtypes)
#   libs       for C++ clients that read tiles or publish reliably: static libraries and headers
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(share ${CMAKE_INSTALL_DATADIR}/voxatlas)
set(config lib/cmake/voxatlas)  # Not an architecture's own folder: both find their prefix from it.

# --- services ---

install(TARGETS vox_cli_main vox_compress_main vox_hub_main vox_ingest_main vox_render_main
                vox_tilestore_main
        RUNTIME COMPONENT services)
# A component of its own, so that the services can be installed without librados; libs/store looks
# for it here.
if(TARGET vox_rados_module)
  install(TARGETS vox_rados_module LIBRARY DESTINATION lib/voxatlas COMPONENT rados)
endif()
install(PROGRAMS scripts/up scripts/demo scripts/in_namespace
        DESTINATION ${share}/scripts COMPONENT services)
install(DIRECTORY scripts/lib DESTINATION ${share}/scripts COMPONENT services
        FILES_MATCHING PATTERN *.py)
foreach(script up demo)
  file(CREATE_LINK ../${share}/scripts/${script} ${PROJECT_BINARY_DIR}/voxatlas-${script} SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/voxatlas-${script}
          DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT services)
endforeach()
install(DIRECTORY scripts/systemd/ DESTINATION lib/systemd/system COMPONENT services
        FILES_MATCHING PATTERN *.service PATTERN *.target PATTERN *.conf)
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT services)

# --- types ---

file(GLOB types CONFIGURE_DEPENDS lcmtypes/*.lcm)
install(FILES ${types} lcmtypes/README.md DESTINATION ${share}/lcmtypes COMPONENT types)
install(DIRECTORY ${PROJECT_BINARY_DIR}/lcmtypes/generated/voxatlas
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT types)
install(TARGETS vox_lcm vox_lcmtypes EXPORT voxatlas-types)
install(EXPORT voxatlas-types NAMESPACE voxatlas:: DESTINATION ${config} COMPONENT types)
configure_file(scripts/cmake/voxatlas.pc.in voxatlas.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/voxatlas.pc
        DESTINATION lib/pkgconfig COMPONENT types)
configure_file(scripts/cmake/voxatlas-config.cmake.in voxatlas-config.cmake @ONLY)
write_basic_package_version_file(voxatlas-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/voxatlas-config.cmake
              ${PROJECT_BINARY_DIR}/voxatlas-config-version.cmake
        DESTINATION ${config} COMPONENT types)

# --- libs: what a client can use of ours, and all that this stands on ---

set(libs base geodesy grid octree integrate codec bus)
foreach(lib IN LISTS libs)
  install(TARGETS vox_${lib} EXPORT voxatlas-libs ARCHIVE COMPONENT libs)
  install(DIRECTORY libs/${lib} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/voxatlas/libs COMPONENT libs
          FILES_MATCHING PATTERN *.hpp)
endforeach()
install(TARGETS vox_octomap vox_geographic EXPORT voxatlas-libs)
install(EXPORT voxatlas-libs NAMESPACE voxatlas:: DESTINATION ${config} COMPONENT libs)
