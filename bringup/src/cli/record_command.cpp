// SPDX-License-Identifier: Apache-2.0
#include "bringup/cli/record_command.hpp"

#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include "bringup/bag/recorder.hpp"
#include "bringup/system/super_client.hpp"
#include "tandem/runtime/node.hpp"
#include "tandem/runtime/shutdown.hpp"

namespace tandem {
namespace {

// rosbag2's default name.
std::string default_folder() {
  char name[64];
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::strftime(name, sizeof name, "rosbag2_%Y_%m_%d-%H_%M_%S", &local);
  return name;
}

void record(const RecordRequest& request) {
  rt::install_signal_handlers();
  rt::Node node{"tandem_record"};
  Recorder recorder{node, request};
  node.log().info("recording until Ctrl-C");
  node.spin();
  for (const auto& name : recorder.unpublished()) node.log().warn("no program published {}", name);
  std::printf("%lld messages of %zu topics in %s\n", static_cast<long long>(recorder.messages()),
              recorder.topics(), request.folder.c_str());
}

}  // namespace

void add_record_command(CLI::App& app) {
  auto request = std::make_shared<RecordRequest>();
  auto* command = app.add_subcommand("record", "Record topics until Ctrl-C in rosbag2's format");
  command->add_option("topics", request->topics,
                      "topics to record; default: every topic that is not hidden");
  command->add_option("-o,--output", request->folder, "output folder; default: rosbag2_<date>");
  command
      ->add_option(
          "-s,--storage", request->storage,
          "mcap, which rosbag2 writes since Iron and today's tools open, or sqlite3, which "
          "ROS 2 Humble reads, too")
      ->check(CLI::IsMember({"mcap", "sqlite3"}))
      ->capture_default_str();
  command->callback([request] {
    if (request->folder.empty()) request->folder = default_folder();
    become_super_client();
    record(*request);
  });
}

}  // namespace tandem
