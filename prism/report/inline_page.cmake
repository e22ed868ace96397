# cmake -DPAGE_DIR= -DTHREE_DIR= -DDYGRAPHS_DIR= -DOUTPUT= -P inline_page.cmake
# Puts styles, scripts and libraries into report.html and writes it as a C++ string.
file(READ ${PAGE_DIR}/report.html page)
foreach(entry IN ITEMS
    "dygraph.min.css;${DYGRAPHS_DIR}/dygraph.min.css"
    "report.css;${PAGE_DIR}/report.css"
    "three.min.js;${THREE_DIR}/three.min.js"
    "OrbitControls.js;${THREE_DIR}/examples/js/controls/OrbitControls.js"
    "dygraph.min.js;${DYGRAPHS_DIR}/dygraph.min.js"
    "view3d.js;${PAGE_DIR}/view3d.js"
    "map2d.js;${PAGE_DIR}/map2d.js"
    "downloads.js;${PAGE_DIR}/downloads.js"
    "keyframe_panel.js;${PAGE_DIR}/keyframe_panel.js"
    "plots.js;${PAGE_DIR}/plots.js"
    "report.js;${PAGE_DIR}/report.js")
  list(GET entry 0 name)
  list(GET entry 1 path)
  file(READ ${path} text)
  # A map of the minified source would be asked for over the network.
  string(REGEX REPLACE "//# sourceMappingURL=[^\n]*" "" text "${text}")
  string(REGEX REPLACE "/\\*# sourceMappingURL=[^*]*\\*/" "" text "${text}")
  string(REPLACE "%${name}%" "${text}" page "${page}")
endforeach()
file(WRITE ${OUTPUT} "#include \"prism/report/report_page.h\"\n\nnamespace prism {\nconst char* const kReportPage = R\"prism_page(${page})prism_page\";\n}\n")
