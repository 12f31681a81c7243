# SPDX-License-Identifier: Apache-2.0
# tandem_add_component(<name> SOURCES <files...> [LINK <targets...>]): target tandem_<name>, the
# module libtandem_<name>.so that `tandem run` loads for `component: <name>`. One of its sources
# contains TANDEM_COMPONENT(Type, "<name>"). Installed beside Tandem's own modules.
function(tandem_add_component name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINK" ${ARGN})
  if(NOT name MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "tandem_add_component: the name '${name}' must consist of a-z, 0-9 and _ and "
                        "begin with a letter")
  endif()
  add_library(tandem_${name} MODULE ${arg_SOURCES})
  target_link_libraries(tandem_${name} PRIVATE tandem::runtime ${arg_LINK})
  set_target_properties(tandem_${name} PROPERTIES INSTALL_RPATH "$ORIGIN/..")
  include(GNUInstallDirs)
  install(TARGETS tandem_${name} DESTINATION ${CMAKE_INSTALL_LIBDIR}/tandem)
endfunction()
