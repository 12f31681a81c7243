# SPDX-License-Identifier: Apache-2.0
# tandem_add_component(<name> SOURCES <files...> [LINK <targets...>] [PACKAGE <name>]): target
# tandem_<name>, the module libtandem_<name>.so that `tandem run` loads for `component: <name>`. One of
# its sources contains TANDEM_COMPONENT(Type, "<name>"). Installed beside Tandem's own modules.
# PACKAGE: what `ros2 component load` calls the package; the name of the CMake project unless given.
function(tandem_add_component name)
  cmake_parse_arguments(arg "" "PACKAGE" "SOURCES;LINK" ${ARGN})
  if(NOT arg_PACKAGE)
    set(arg_PACKAGE ${PROJECT_NAME})
  endif()
  foreach(word ${name} ${arg_PACKAGE})
    string(LENGTH "${word}" length)
    if(NOT word MATCHES "^[a-z][a-z0-9_]*$" OR length GREATER 63)
      message(FATAL_ERROR "tandem_add_component: '${word}' must consist of a-z, 0-9 and _, begin with a "
                          "letter and have at most 63 characters (PACKAGE: unless given, the project's name)")
    endif()
  endforeach()
  add_library(tandem_${name} MODULE ${arg_SOURCES})
  target_compile_definitions(tandem_${name} PRIVATE TANDEM_PACKAGE="${arg_PACKAGE}")
  target_link_libraries(tandem_${name} PRIVATE tandem::runtime ${arg_LINK})
  set_target_properties(tandem_${name} PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
                        INSTALL_RPATH "$ORIGIN/..")
  include(GNUInstallDirs)
  # It exports nothing, neither of its own code nor of the static libraries that it links: two modules
  # may contain different versions of the same function. It contains only the functions that it uses.
  target_link_options(tandem_${name} PRIVATE LINKER:--exclude-libs,ALL LINKER:--gc-sections)
  install(TARGETS tandem_${name} DESTINATION ${CMAKE_INSTALL_LIBDIR}/tandem)
  # For colcon, which adds it to the setup file of a workspace if the package's colcon.pkg names it.
  if(NOT PROJECT_NAME STREQUAL "tandem")
    set(hook ${CMAKE_CURRENT_BINARY_DIR}/tandem_component_path.dsv)
    file(WRITE ${hook} "prepend-non-duplicate;TANDEM_COMPONENT_PATH;${CMAKE_INSTALL_LIBDIR}/tandem\n")
    install(FILES ${hook} DESTINATION ${CMAKE_INSTALL_DATADIR}/${PROJECT_NAME}/hook)
  endif()
endfunction()
