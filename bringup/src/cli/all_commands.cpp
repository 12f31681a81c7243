// SPDX-License-Identifier: Apache-2.0
// All commands of the program `tandem`; libtandem-commands.so.
#include "bringup/cli/describe_command.hpp"
#include "bringup/cli/map_command.hpp"
#include "bringup/cli/measure_command.hpp"
#include "bringup/cli/metrics_command.hpp"
#include "bringup/cli/play_command.hpp"
#include "bringup/cli/record_command.hpp"
#include "bringup/cli/robot_command.hpp"
#include "bringup/cli/scenario_command.hpp"
#include "bringup/cli/security_command.hpp"
#include "bringup/cli/study_command.hpp"
#include "bringup/cli/teleop_command.hpp"
#include "bringup/command_line/command_line.hpp"
#include "bringup/command_line/run_command.hpp"
#include "bringup/system/container.hpp"
#include "bringup/system/doctor.hpp"

namespace {

void add_commands(CLI::App& app, int& status) {
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
}

}  // namespace

extern "C" __attribute__((visibility("default"))) int tandem_commands(int argc, char** argv) {
  return tandem::run_command_line(argc, argv, add_commands);
}
