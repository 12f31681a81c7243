// SPDX-License-Identifier: Apache-2.0
#include "bringup/command_line/run_command.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "bringup/system/shared_files.hpp"
#include "bringup/system/system.hpp"
#include "tandem/runtime/component.hpp"

namespace tandem {

void add_run_command(CLI::App& app, int& status) {
  struct Request {
    std::string file;
    std::vector<std::string> only;
    bool separate = false;
  };
  auto request = std::make_shared<Request>();
  auto* run = app.add_subcommand("run", "Compose the components of a system and run them");
  run->add_option("file", request->file, "system file, or name of a system that comes with Tandem")
      ->required();
  run->add_option("--only", request->only, "run only the nodes with these names");
  run->add_flag("--separate", request->separate, "one process per component");
  run->allow_extras();  // --ros-args …
  run->footer("Accepts ROS 2's --ros-args -r from:=to -p key:=value --params-file FILE.");
  run->callback([request, run, &status] {
    status = run_system(find_file(request->file, "systems"), request->only, request->separate,
                        run->remaining());
  });

  auto* list = app.add_subcommand(
      "list", "List the components that can be run; TANDEM_COMPONENT_PATH adds folders");
  list->callback([] {
    for (const auto& name : rt::list_components()) std::printf("%s\n", name.c_str());
  });
}

}  // namespace tandem
