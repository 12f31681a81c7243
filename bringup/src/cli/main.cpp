// SPDX-License-Identifier: Apache-2.0
// Entry point of the program `tandem` with all its commands.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>

#include "bringup/cli/describe_command.hpp"
#include "bringup/cli/map_command.hpp"
#include "bringup/cli/measure_command.hpp"
#include "bringup/cli/metrics_command.hpp"
#include "bringup/cli/play_command.hpp"
#include "bringup/cli/record_command.hpp"
#include "bringup/cli/robot_command.hpp"
#include "bringup/cli/run_command.hpp"
#include "bringup/cli/scenario_command.hpp"
#include "bringup/cli/security_command.hpp"
#include "bringup/cli/study_command.hpp"
#include "bringup/cli/teleop_command.hpp"
#include "bringup/system/container.hpp"
#include "bringup/system/doctor.hpp"
#include "tandem/version.hpp"

namespace {

// The word in the position of a required command; empty if there is none.
std::string unknown_command(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  const auto words = at->remaining();
  return at->get_require_subcommand_min() == 0 || words.empty() ? "" : words.front();
}

// The system's message about the limit of threads and processes does not name the remedy.
std::string explained(const std::exception& error) {
  const std::string what = error.what();
  const auto no_more = std::make_error_code(std::errc::resource_unavailable_try_again).message();
  return what.find(no_more) == std::string::npos
             ? what
             : what + ": no more threads or processes for this user; raise `ulimit -u`";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Tandem: shared control for differential-drive robots"};
  app.require_subcommand(1);
  app.set_version_flag("--version", "tandem " TANDEM_VERSION);
  int status = 0;
  tandem::add_run_command(app, status);
  tandem::add_container_command(app);
  tandem::add_teleop_command(app);
  tandem::add_scenario_command(app, status);
  tandem::add_study_command(app);
  tandem::add_record_command(app);
  tandem::add_play_command(app);
  tandem::add_metrics_command(app);
  tandem::add_measure_command(app);
  tandem::add_robot_command(app);
  tandem::add_doctor_command(app, status);
  tandem::add_describe_command(app);
  tandem::add_map_command(app);
  tandem::add_security_command(app);
  for (const char* command : {"run", "container", "teleop", "scenario", "record", "play", "doctor"})
    tandem::add_enclave_option(*app.get_subcommand(command));
  try {
    for (int i = 1; i < argc; ++i)  // CLI11 would treat an empty argument as not given
      if (*argv[i] == '\0')
        throw std::invalid_argument("argument " + std::to_string(i) +
                                    " is empty; is a variable of the shell unset?");
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error(
          "cannot write to standard output (is the disk full, or was the pipe closed?)");
    return status;
  } catch (const CLI::RequiredError& error) {
    const std::string unknown = unknown_command(app);
    if (unknown.empty()) return app.exit(error), 1;
    std::fprintf(stderr, "tandem: no command '%s'; --help lists them\n", unknown.c_str());
    return 1;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;  // exit() returns 0 for --help
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tandem: %s\n", explained(error).c_str());
    return 1;
  }
}
