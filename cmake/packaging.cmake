# A Debian package of what `cmake --install` installs: `cpack --config build/release/CPackConfig.cmake`.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME prism-vo)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Metric visual odometry for focused plenoptic cameras")
set(CPACK_PACKAGE_CONTACT "The PRISM-VO developers")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # what the programs run with
# What programs of others are built with against the library.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libceres-dev, libeigen3-dev, libopencv-dev, libgoogle-glog-dev, \
libyaml-cpp-dev, libpugixml-dev, libtbb-dev, libhwy-dev, python3-numpy")
include(CPack)
