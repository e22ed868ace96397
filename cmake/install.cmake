# Installs the package `prism`: prism_module() has marked what belongs to it, the umbrella target
# prism::prism links all of that.
add_library(prism_module_prism INTERFACE)
add_library(prism::prism ALIAS prism_module_prism)
set_target_properties(prism_module_prism PROPERTIES EXPORT_NAME prism)
get_property(modules GLOBAL PROPERTY PRISM_INSTALLED_MODULES)
foreach(module IN LISTS modules)
  target_link_libraries(prism_module_prism INTERFACE prism::${module})
endforeach()

if(PRISM_INSTALL)
  include(CMakePackageConfigHelpers)
  set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/prism)
  install(TARGETS prism_module_prism EXPORT prismTargets)
  install(EXPORT prismTargets NAMESPACE prism:: DESTINATION ${package_dir})
  configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/prismConfig.cmake.in
    ${PROJECT_BINARY_DIR}/prismConfig.cmake INSTALL_DESTINATION ${package_dir})
  # Until version 1 every minor version may change the interface.
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/prismConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/prismConfig.cmake
                ${PROJECT_BINARY_DIR}/prismConfigVersion.cmake DESTINATION ${package_dir})
endif()
