# SPDX-License-Identifier: Apache-2.0
# tandem_pkg_config(<target> <name> [<links...>]): installs tandem-<name>.pc for a library and what it
# links: targets tandem::<room> or of the table below.
set(pkg_config_of_Eigen3::Eigen eigen3)
set(pkg_config_of_yaml-cpp::yaml-cpp yaml-cpp)
set(pkg_config_of_spdlog::spdlog spdlog)
set(pkg_config_of_nlohmann_json::nlohmann_json nlohmann_json)
set(pkg_config_of_PkgConfig::PNG libpng)
set(pkg_config_of_octomap_lib octomap)
# Without a .pc file, or linked in an order that matters.
set(flags_of_ipopt_lib ${TANDEM_SEQUENTIAL_MUMPS} -lipopt)
set(flags_of_Threads::Threads -pthread)
set(flags_of_${TANDEM_FASTDDS} -l${TANDEM_FASTDDS})
set(flags_of_fastcdr -lfastcdr)

function(tandem_pkg_config target name)
  set(requires)
  set(flags)
  foreach(link IN LISTS ARGN)
    if(link MATCHES "^tandem::(.+)$")
      list(APPEND requires tandem-${CMAKE_MATCH_1})
    elseif(DEFINED pkg_config_of_${link})
      list(APPEND requires ${pkg_config_of_${link}})
    elseif(DEFINED flags_of_${link})
      list(APPEND flags ${flags_of_${link}})
    else()
      message(FATAL_ERROR "tandem_pkg_config: how does pkg-config name ${link}? Add it to its table")
    endif()
  endforeach()
  list(JOIN requires " " requires)
  list(JOIN flags " " flags)
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL "INTERFACE_LIBRARY")
    string(PREPEND flags "-L\${libdir} -l${target} ")
  endif()
  set(include "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
  if(name STREQUAL "msgs")
    string(APPEND include "/tandem/msgs")
  endif()
  set(file ${CMAKE_CURRENT_BINARY_DIR}/tandem-${name}.pc)
  file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  file(WRITE ${file} "prefix=\${pcfiledir}/${up}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}

Name: tandem-${name}
Description: Tandem's library ${name}
Version: ${PROJECT_VERSION}
Requires: ${requires}
Libs: ${flags}
Cflags: -std=c++20 -I${include}
")
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
