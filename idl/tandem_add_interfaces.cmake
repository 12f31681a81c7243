# SPDX-License-Identifier: Apache-2.0
# C++ types of messages, services and actions, and their type hashes, from IDL.

# tandem_generate_types(<target> FROM <folder> PACKAGES <names...> HEADER <file> [KNOWN <names...>]):
# static library of the types of FROM/<package>.idl. Packages come after those that they use. HEADER:
# the generated header, relative to the target's include folder <binary folder>/gen/<target>. KNOWN: packages of
# Tandem that the IDL may use.
function(tandem_generate_types target)
  cmake_parse_arguments(arg "" "FROM;HEADER" "PACKAGES;KNOWN" ${ARGN})
  set(gen ${CMAKE_CURRENT_BINARY_DIR}/gen/${target})
  set(code ${gen}/types)  # written by fastddsgen
  find_program(FASTDDSGEN fastddsgen REQUIRED)
  if(TANDEM_FASTDDS STREQUAL fastdds)  # fastddsgen 4 (Fast DDS 3)
    set(header hpp)
    set(sources PubSubTypes.cxx)
    set(options -no-typeobjectsupport)
  else()
    set(header h)
    set(sources .cxx PubSubTypes.cxx)
    set(options)
  endif()

  set(includes)
  set(types)      # MessageType<M> of each structure
  set(services)   # S::Request, S::Response, S::name
  set(actions)    # A::Goal, A::Result, A::Feedback, and what carries them
  set(creators)   # MessageType<M>::create()
  set(pubsub_includes)
  set(generated)
  set(idls)
  set(paths)
  foreach(package ${arg_PACKAGES})
    set(idl ${package}.idl)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${arg_FROM}/${idl})
    list(APPEND idls ${idl})
    list(APPEND paths ${arg_FROM}/${idl})
    string(APPEND includes "#include \"${package}.${header}\"\n")
    string(APPEND pubsub_includes "#include \"${package}PubSubTypes.${header}\"\n")
    foreach(suffix ${sources})
      list(APPEND generated ${code}/${package}${suffix})
    endforeach()
    file(STRINGS ${arg_FROM}/${idl} lines REGEX "module (msg|srv|action) |^ *struct ")
    foreach(line IN LISTS lines)
      if(line MATCHES "module (msg|srv|action) ")
        set(kind ${CMAKE_MATCH_1})
      elseif(line MATCHES "struct ([A-Za-z0-9_]+)")
        set(name ${CMAKE_MATCH_1})
        set(type ${package}::${kind}::${name})
        string(APPEND types "template <>\nstruct MessageType<${type}> {\n"
               "  static constexpr const char* name = \"${package}/${kind}/${name}\";\n"
               "  static std::unique_ptr<eprosima::fastdds::dds::TopicDataType> create();\n};\n")
        string(APPEND creators "std::unique_ptr<eprosima::fastdds::dds::TopicDataType> "
               "MessageType<${type}>::create() {\n  return create_checked<${type}PubSubType>();\n}\n")
        if(name MATCHES "(.+)_Request")
          set(service ${CMAKE_MATCH_1})
          string(APPEND services "namespace tandem::${package}::${kind} {\nstruct ${service} {\n"
                 "  using Request = ${service}_Request;\n  using Response = ${service}_Response;\n"
                 "  static constexpr const char* name = \"${package}/${kind}/${service}\";\n};\n}\n")
        elseif(name MATCHES "(.+)_FeedbackMessage")
          set(action ${CMAKE_MATCH_1})
          string(APPEND actions "namespace tandem::${package}::action {\nstruct ${action} {\n")
          foreach(part Goal Result Feedback SendGoal GetResult FeedbackMessage)
            string(APPEND actions "  using ${part} = ${action}_${part};\n")
          endforeach()
          string(APPEND actions "  static constexpr const char* name = \"${package}/action/${action}\";\n};\n}\n")
        endif()
      endif()
    endforeach()
  endforeach()
  file(CONFIGURE OUTPUT ${gen}/${arg_HEADER} @ONLY CONTENT "#pragma once
#include \"msgs.hpp\"
@includes@
@services@
@actions@
namespace tandem::runtime {
@types@}
")
  file(CONFIGURE OUTPUT ${gen}/${target}_list.cpp @ONLY CONTENT "#include \"@arg_HEADER@\"
#include \"checked_type.hpp\"
#include \"@target@_hashes.hpp\"
@pubsub_includes@
namespace tandem::runtime {
@creators@}
")

  set(known_idls ${arg_KNOWN})
  list(TRANSFORM known_idls REPLACE "(.+)" "${TANDEM_IDL_DIR}/\\1.idl")
  string(REPLACE ";" " " known "${arg_KNOWN}")
  set(folders "-I .")
  if(NOT arg_FROM STREQUAL TANDEM_IDL_DIR)  # fastddsgen 4.0 never ends if it is given a folder twice
    string(APPEND folders " -I ${TANDEM_IDL_DIR}")
  endif()
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/generate_types ${code}
            "${FASTDDSGEN} -replace -cs -typeros2 ${options} ${folders}" "${known}" ${idls}
    WORKING_DIRECTORY ${arg_FROM}
    DEPENDS ${paths} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/generate_types
    VERBATIM
    COMMENT "fastddsgen: messages from IDL")
  # ROS 2 compares type hashes to detect differing definitions of a type.
  add_custom_command(OUTPUT ${gen}/${target}_hashes.hpp
    COMMAND tandem::hash_types ${gen}/${target}_hashes.hpp ${idls} --known ${known_idls}
    WORKING_DIRECTORY ${arg_FROM}
    DEPENDS ${paths} tandem::hash_types
    VERBATIM
    COMMENT "Type hashes from IDL")

  add_library(${target} STATIC ${generated} ${gen}/${target}_list.cpp ${gen}/${target}_hashes.hpp)
  target_include_directories(${target} SYSTEM PUBLIC $<BUILD_INTERFACE:${code}> $<BUILD_INTERFACE:${gen}>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  # This code is not hot but takes long to compile: few unity files, less optimisation, no warnings.
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 18)
  target_compile_options(${target} PRIVATE -w -O1)
endfunction()

# tandem_add_interfaces(<package> FILES <files...>): target <package>, a library of the package's
# messages, services and actions; include <package>/messages.hpp. The types are in the namespace tandem
# (tandem::<package>::msg::X) and are used with topics, services and actions as Tandem's own. FILES: .msg, .srv
# and .action files, or the one file <package>.idl in the form of Tandem's (share/tandem/idl). They may use the
# packages of Tandem. Needs fastddsgen, and Python 3 for all but IDL.
function(tandem_add_interfaces package)
  cmake_parse_arguments(arg "" "" "FILES" ${ARGN})
  if(NOT package MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "tandem_add_interfaces: the package '${package}' must consist of a-z, 0-9 and _ and "
                        "begin with a letter")
  endif()
  file(GLOB known RELATIVE ${TANDEM_IDL_DIR} ${TANDEM_IDL_DIR}/*.idl)
  list(TRANSFORM known REPLACE "\\.idl$" "")
  if(package IN_LIST known)
    message(FATAL_ERROR "tandem_add_interfaces: Tandem has the package '${package}' itself")
  endif()
  set(files)
  foreach(file IN LISTS arg_FILES)
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    list(APPEND files ${file})
  endforeach()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  set(from ${CMAKE_CURRENT_BINARY_DIR}/gen/${package}/idl)
  set(idl ${from}/${package}.idl)
  file(MAKE_DIRECTORY ${from})
  if(files MATCHES "/${package}\\.idl$")
    configure_file(${files} ${idl} COPYONLY)
  else()
    execute_process(COMMAND ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/messages_to_idl ${idl} ${TANDEM_IDL_DIR} ${files}
                    RESULT_VARIABLE failed ERROR_VARIABLE error)
    if(failed)
      message(FATAL_ERROR "tandem_add_interfaces: ${error}")
    endif()
  endif()
  tandem_generate_types(${package} FROM ${from} PACKAGES ${package} HEADER ${package}/messages.hpp KNOWN ${known})
  target_link_libraries(${package} PUBLIC tandem::runtime)
endfunction()
