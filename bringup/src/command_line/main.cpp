// SPDX-License-Identifier: Apache-2.0
// Entry point of the program `tandem`. It contains the commands `run` and `container`, which start
// robots; the others are in an extension, with their libraries for pictures, studies and
// recordings.
#include <cstdio>
#include <exception>
#include <string_view>

#include "bringup/command_line/command_line.hpp"
#include "bringup/command_line/run_command.hpp"
#include "bringup/system/container.hpp"
#include "tandem/runtime/extension.hpp"

namespace {

void add_commands_of_a_robot(CLI::App& app, int& status) {
  tandem::add_run_command(app, status);
  tandem::add_container_command(app);
  for (const char* command : {"run", "container"})
    tandem::add_enclave_option(*app.get_subcommand(command));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view command = argc > 1 ? argv[1] : "";
  if (command == "run" || command == "container")
    return tandem::run_command_line(argc, argv, add_commands_of_a_robot);
  try {
    void* commands = tandem::runtime::function_of_extension("commands", "tandem_commands");
    return reinterpret_cast<int (*)(int, char**)>(commands)(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", error.what());
    return 1;
  }
}
