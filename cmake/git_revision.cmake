# Writes the git revision into a header at build time (only when it changes), for run.json.
add_custom_target(prism_git_revision
  COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR}
          -DOUTPUT=${PROJECT_BINARY_DIR}/generated/prism_git_revision.h
          -P ${PROJECT_SOURCE_DIR}/cmake/write_git_revision.cmake
  BYPRODUCTS ${PROJECT_BINARY_DIR}/generated/prism_git_revision.h
  COMMENT "")
