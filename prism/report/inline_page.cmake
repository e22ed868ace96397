# cmake -DPAGE_DIR= -DPAGE=report.html -DNAME=kReportPage -DTHREE_DIR= -DDYGRAPHS_DIR= -DOUTPUT=
#       "-DFILES=a.css b.js" -P inline_page.cmake
# Puts styles, scripts and libraries into a page and writes it as a C++ string. FILES: the project's
# own, each at its %name% in the page.
separate_arguments(FILES)
file(READ ${PAGE_DIR}/${PAGE} page)
foreach(path IN ITEMS
    ${DYGRAPHS_DIR}/dygraph.min.css
    ${THREE_DIR}/three.min.js
    ${THREE_DIR}/examples/js/controls/OrbitControls.js
    ${DYGRAPHS_DIR}/dygraph.min.js
    ${FILES})
  get_filename_component(name ${path} NAME)
  file(READ ${path} text)
  # A map of the minified source would be asked for over the network.
  string(REGEX REPLACE "//# sourceMappingURL=[^\n]*" "" text "${text}")
  string(REGEX REPLACE "/\\*# sourceMappingURL=[^*]*\\*/" "" text "${text}")
  string(REPLACE "%${name}%" "${text}" page "${page}")
endforeach()
file(WRITE ${OUTPUT} "#include \"prism/report/report_page.h\"\n\nnamespace prism {\nconst char* const ${NAME} = R\"prism_page(${page})prism_page\";\n}\n")
